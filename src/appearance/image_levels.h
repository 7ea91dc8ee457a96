/// The copies of an image for the kernels.
#pragma once

#include "appearance/texture.h"
#include "kernels/shading_cell.h"

namespace kagero {

/// Lists an image and its coarser copies, which must outlive it.
class ImageLevelTable {
public:
    ImageLevelTable(const StoredImage& image, const std::vector<Image>& coarser);
    /// Returns the levels. The result is valid as long as this object.
    ImageLevels levels(Edges edges) const;

private:
    ImageLevels::Components components_{};
    const float* linear_ = nullptr;
    std::vector<ImageLevel> levels_;
};

}  // namespace kagero
