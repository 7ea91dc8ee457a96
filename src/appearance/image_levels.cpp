#include "appearance/image_levels.h"

#include <type_traits>

namespace kagero {

ImageLevelTable::ImageLevelTable(const StoredImage& image, const std::vector<Image>& coarser) {
    visit_texels(image, [&](const auto& texels) {
        using Stored = std::remove_cvref_t<decltype(*texels.stored)>;
        using enum ImageLevels::Components;
        components_ = std::is_same_v<Stored, float> ? floats : sizeof(Stored) == 1 ? bytes : words;
        linear_ = texels.linear;
        levels_.push_back({texels.stored, texels.width, texels.height});
    });
    for (const Image& level : coarser) levels_.push_back({level.rgb.data(), level.width, level.height});
}

ImageLevels ImageLevelTable::levels(Edges edges) const {
    return {components_,
            edges.along_u == BeyondEdge::repeat,
            edges.along_v == BeyondEdge::repeat,
            linear_,
            static_cast<std::uint32_t>(levels_.size()),
            levels_.data()};
}

}  // namespace kagero
