#include "geometry/files/gltf/accessor.h"

#include <algorithm>
#include <cstring>

namespace kagero {

namespace {

using nlohmann::json;

/// The types of numbers in a buffer, with their codes in the file.
enum ComponentType : std::uint64_t {
    int8 = 5120,
    uint8 = 5121,
    int16 = 5122,
    uint16 = 5123,
    uint32 = 5125,
    float32 = 5126
};

std::size_t component_size(std::uint64_t type) {
    return type == int8 || type == uint8 ? 1 : type == int16 || type == uint16 ? 2 : 4;
}

/// Maximum number of elements of an accessor whose numbers are not in the file, because they are zero.
constexpr std::uint64_t max_zeros = std::uint64_t{1} << 16;

/// Declaration of an accessor, or of a part of a sparse one.
struct Layout {
    std::uint64_t component_type = float32;
    std::size_t components = 1;  ///< Numbers per element.
    bool is_normalized = false;

    std::size_t element_size() const { return components * component_size(component_type); }
};

template <class Number>
Number loaded(const char* bytes) {
    Number number;
    std::memcpy(&number, bytes, sizeof number);  // glTF is little-endian, like the processors that kagero supports
    return number;
}

/// Returns one number. A normalized integer is divided by the greatest value of its type.
double decode(const Layout& layout, const char* bytes) {
    const double divisors[] = {127, 255, 32767, 65535};
    double number = 0;
    switch (layout.component_type) {
        case int8: number = loaded<std::int8_t>(bytes); break;
        case uint8: number = loaded<std::uint8_t>(bytes); break;
        case int16: number = loaded<std::int16_t>(bytes); break;
        case uint16: number = loaded<std::uint16_t>(bytes); break;
        case uint32: return loaded<std::uint32_t>(bytes);
        default: return double(loaded<float>(bytes));
    }
    return layout.is_normalized ? std::max(number / divisors[layout.component_type - int8], -1.0) : number;
}

/// Checks that a view contains `count` elements from an offset on, and returns their first byte and their distance.
std::pair<const char*, std::size_t> elements_of(const GltfDocument& document, const GltfView& view,
                                                const Layout& layout, std::uint64_t offset, std::uint64_t count,
                                                const std::string& name) {
    const std::size_t size = layout.element_size(), stride = view.stride == 0 ? size : view.stride;
    if (stride < size)
        refuse_gltf(document.source, name + " has elements of " + std::to_string(size) +
                                         " bytes, but the byteStride of its view is " + std::to_string(stride));
    const std::size_t available = view.bytes.size();
    if (offset > available || available - offset < size || count - 1 > (available - offset - size) / stride)
        refuse_gltf(document.source, name + " has " + std::to_string(count) + " elements of " + std::to_string(size) +
                                         " bytes from offset " + std::to_string(offset) +
                                         " on, which exceed the view's " + std::to_string(available) + " bytes");
    return {view.bytes.data() + offset, stride};
}

/// Returns the component types that the use allows. The extension KHR_mesh_quantization allows more of them.
std::vector<std::uint64_t> legal_types(const GltfDocument& document, GltfUse use) {
    if (use == GltfUse::indices) return {uint8, uint16, uint32};
    if (uses_extension(document, "KHR_mesh_quantization")) return {int8, uint8, int16, uint16, float32};
    if (use == GltfUse::texture_coordinates) return {uint8, uint16, float32};
    return {float32};
}

Layout layout_of(const GltfDocument& document, const json& accessor, GltfUse use, const std::string& name) {
    Layout layout;
    layout.component_type = whole_number(document, accessor, "componentType", name, no_default);
    const std::vector<std::uint64_t> types = legal_types(document, use);
    if (std::find(types.begin(), types.end(), layout.component_type) == types.end()) {
        std::string legal;
        for (const std::uint64_t type : types) append_to_list(legal, std::to_string(type));
        refuse_gltf(document.source, name + ".componentType = " + std::to_string(layout.component_type) +
                                         " is not legal for this use; legal are " + legal);
    }
    const std::string expected = use == GltfUse::indices               ? "SCALAR"
                                 : use == GltfUse::texture_coordinates ? "VEC2"
                                                                       : "VEC3";
    layout.components = use == GltfUse::indices ? 1 : use == GltfUse::texture_coordinates ? 2 : 3;
    const json* type = find_member(document, accessor, "type", name);
    if (!type || *type != expected)
        refuse_gltf(document.source, name + ".type = " + (type ? text_of(*type) : "\"\"") + " must be " + expected);
    const json* normalized = find_member(document, accessor, "normalized", name);
    layout.is_normalized = normalized && *normalized == true;
    return layout;
}

std::uint64_t view_index(const GltfDocument& document, const json& object, const std::string& name) {
    const json* view = find_member(document, object, "bufferView", name);
    if (!view) refuse_gltf(document.source, name + " has no bufferView, which is required");
    return index_of(document, *view, "bufferViews", name + ".bufferView");
}

/// Replaces some elements by those of a sparse accessor.
void replace_elements(const GltfDocument& document, GltfBuffers& buffers, const json& sparse, const Layout& layout,
                      const std::string& name, std::vector<double>& numbers) {
    const std::uint64_t elements = numbers.size() / layout.components;
    const std::uint64_t count = whole_number(document, sparse, "count", name, no_default);
    if (count < 1 || count > elements)
        refuse_gltf(document.source, name + ".count = " + std::to_string(count) + " is not legal; it must be 1 to " +
                                         std::to_string(elements));
    const auto part = [&](const char* key) -> const json& {
        const json* member = find_member(document, sparse, key, name);
        if (!member) refuse_gltf(document.source, name + " has no " + key + ", which are required");
        return *member;
    };
    const json &indices = part("indices"), &values = part("values");
    const std::string indices_name = name + ".indices", values_name = name + ".values";
    Layout index_layout;
    index_layout.component_type = whole_number(document, indices, "componentType", indices_name, no_default);
    const std::uint64_t type = index_layout.component_type;
    if (type != uint8 && type != uint16 && type != uint32)
        refuse_gltf(document.source, indices_name + ".componentType = " + std::to_string(type) +
                                         " is not legal; legal are 5121, 5123 and 5125");
    const auto [index, index_stride] =
        elements_of(document, buffers.view(view_index(document, indices, indices_name)), index_layout,
                    whole_number(document, indices, "byteOffset", indices_name, 0), count, indices_name);
    const auto [element, stride] =
        elements_of(document, buffers.view(view_index(document, values, values_name)), layout,
                    whole_number(document, values, "byteOffset", values_name, 0), count, values_name);
    for (std::uint64_t i = 0; i < count; ++i) {
        const double target = decode(index_layout, index + i * index_stride);
        if (target >= double(elements))
            refuse_gltf(document.source, indices_name + " contains " + number_text(target) +
                                             ", but the accessor has only " + std::to_string(elements) + " elements");
        for (std::size_t k = 0; k < layout.components; ++k)
            numbers[static_cast<std::size_t>(target) * layout.components + k] =
                decode(layout, element + i * stride + k * component_size(layout.component_type));
    }
}

}  // namespace

std::vector<double> read_accessor(const GltfDocument& document, GltfBuffers& buffers, const json& value, GltfUse use,
                                  const std::string& name) {
    const std::uint64_t index = index_of(document, value, "accessors", name);
    const std::string own_name = "accessors[" + std::to_string(index) + "]";
    const json& accessor = entry_of(document, "accessors", index);
    const Layout layout = layout_of(document, accessor, use, own_name);
    const std::uint64_t count = whole_number(document, accessor, "count", own_name, no_default);
    if (count < 1) refuse_gltf(document.source, own_name + ".count = 0 is not legal; it must be at least 1");
    const json* sparse = find_member(document, accessor, "sparse", own_name);
    std::vector<double> numbers;
    if (find_member(document, accessor, "bufferView", own_name)) {
        const GltfView view = buffers.view(view_index(document, accessor, own_name));
        const auto [first, stride] =
            elements_of(document, view, layout, whole_number(document, accessor, "byteOffset", own_name, 0), count,
                        own_name);
        numbers.reserve(count * layout.components);
        for (std::uint64_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < layout.components; ++k)
                numbers.push_back(decode(layout, first + i * stride + k * component_size(layout.component_type)));
    } else {
        if (!sparse)
            refuse_gltf(document.source, own_name +
                                             " has no bufferView and is not sparse, so it contains no data; an "
                                             "extension that compresses it is not supported");
        if (count > max_zeros)
            refuse_gltf(document.source, own_name + ".count = " + std::to_string(count) +
                                             " is too large without a bufferView; the limit is 2^16");
        numbers.assign(count * layout.components, 0);
    }
    if (sparse) replace_elements(document, buffers, *sparse, layout, own_name + ".sparse", numbers);
    return numbers;
}

}  // namespace kagero
