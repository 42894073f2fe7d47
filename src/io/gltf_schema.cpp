// gltf_schema.cpp — tables of what this reader uses of glTF's JSON, and checks against them.
//
// Source  glTF 2.0 specification, §5 (properties reference).
// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_schema.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "io/gltf_error.h"
#include "io/gltf_front.h"

namespace malus::gltf {
namespace {

constexpr std::int64_t kMostWhole = std::numeric_limits<std::int32_t>::max();

enum class Kind { kText, kFlag, kNumber, kWhole, kNumbers, kWholes };
enum class Need { kOptional, kRequired };

struct Field {
    const char* key;
    Kind kind;
    Need need = Need::kOptional;
    const char* refers_to = nullptr;  // the list a whole number is an index into
    std::size_t size = 0;             // of an array; 0: any
};

constexpr Field kBuffer[] = {{"byteLength", Kind::kWhole, Need::kRequired}};
constexpr Field kBufferView[] = {{"buffer", Kind::kWhole, Need::kRequired, "buffers"},
                                 {"byteOffset", Kind::kWhole},
                                 {"byteLength", Kind::kWhole, Need::kRequired},
                                 {"byteStride", Kind::kWhole}};
constexpr Field kAccessor[] = {{"bufferView", Kind::kWhole, Need::kOptional, "bufferViews"},
                               {"byteOffset", Kind::kWhole},
                               {"componentType", Kind::kWhole, Need::kRequired},
                               {"normalized", Kind::kFlag},
                               {"count", Kind::kWhole, Need::kRequired},
                               {"type", Kind::kText, Need::kRequired}};
constexpr Field kSparse[] = {{"count", Kind::kWhole, Need::kRequired}};
constexpr Field kSparseIndices[] = {{"bufferView", Kind::kWhole, Need::kRequired, "bufferViews"},
                                    {"byteOffset", Kind::kWhole},
                                    {"componentType", Kind::kWhole, Need::kRequired}};
constexpr Field kSparseValues[] = {{"bufferView", Kind::kWhole, Need::kRequired, "bufferViews"},
                                   {"byteOffset", Kind::kWhole}};
constexpr Field kMesh[] = {{"name", Kind::kText}};
constexpr Field kPrimitive[] = {{"indices", Kind::kWhole, Need::kOptional, "accessors"},
                                {"material", Kind::kWhole, Need::kOptional, "materials"},
                                {"mode", Kind::kWhole}};
constexpr Field kNode[] = {{"name", Kind::kText},
                           {"mesh", Kind::kWhole, Need::kOptional, "meshes"},
                           {"camera", Kind::kWhole, Need::kOptional, "cameras"},
                           {"skin", Kind::kWhole, Need::kOptional, "skins"},
                           {"children", Kind::kWholes, Need::kOptional, "nodes"},
                           {"matrix", Kind::kNumbers, Need::kOptional, nullptr, 16},
                           {"translation", Kind::kNumbers, Need::kOptional, nullptr, 3},
                           {"rotation", Kind::kNumbers, Need::kOptional, nullptr, 4},
                           {"scale", Kind::kNumbers, Need::kOptional, nullptr, 3}};
constexpr Field kScene[] = {{"nodes", Kind::kWholes, Need::kOptional, "nodes"}};
constexpr Field kMaterial[] = {{"name", Kind::kText}};
constexpr Field kCamera[] = {{"name", Kind::kText}, {"type", Kind::kText, Need::kRequired}};
constexpr Field kPerspective[] = {{"yfov", Kind::kNumber, Need::kRequired},
                                  {"znear", Kind::kNumber, Need::kRequired},
                                  {"zfar", Kind::kNumber},
                                  {"aspectRatio", Kind::kNumber}};
constexpr Field kOrthographic[] = {{"xmag", Kind::kNumber, Need::kRequired},
                                   {"ymag", Kind::kNumber, Need::kRequired},
                                   {"znear", Kind::kNumber, Need::kRequired},
                                   {"zfar", Kind::kNumber, Need::kRequired}};

constexpr const char* kLists[] = {
    "accessors", "animations", "buffers",  "bufferViews",    "cameras",
    "images",    "materials",  "meshes",   "nodes",          "samplers",
    "scenes",    "skins",      "textures", "extensionsUsed", "extensionsRequired"};

class Checker {
  public:
    explicit Checker(const Json& root) : root_(root) {}

    Json contents() const;
    Json cameras() const;

  private:
    std::size_t list_size(const char* key) const {
        const auto list = root_.find(key);
        return list == root_.end() ? 0 : list->size();
    }
    Json whole(const Json& value, const Field& field, const std::string& place) const;
    Json value(const Json& value, const Field& field, const std::string& place) const;
    Json object(const Json& from, const std::string& place, std::span<const Field> fields) const;
    template <class Clean>
    Json list(const Json& owner, const std::string& place, const char* key, Clean clean) const;
    template <class Clean>
    Json top_list(const char* key, Clean clean) const {
        return root_.contains(key) ? list(root_, "", key, clean) : Json::array();
    }
    Json buffer_view(const Json& from, const std::string& place) const;
    Json accessor(const Json& from, const std::string& place) const;
    Json sparse(const Json& from, const std::string& place) const;
    Json primitive(const Json& from, const std::string& place) const;
    Json node(const Json& from, const std::string& place) const;
    Json camera(const Json& from, const std::string& place) const;

    const Json& root_;
};

Json Checker::whole(const Json& value, const Field& field, const std::string& place) const {
    const auto n = as_whole(value);
    if (!n)
        fail(place,
             shown(value) + " is not a whole number from 0 to " + std::to_string(kMostWhole));
    if (field.refers_to != nullptr) {
        const std::size_t size = list_size(field.refers_to);
        if (static_cast<std::size_t>(*n) >= size)
            fail(place, "index " + std::to_string(*n) + " is out of range (the file has " +
                            std::to_string(size) + " " + field.refers_to + ")");
    }
    return *n;
}

Json Checker::value(const Json& value, const Field& field, const std::string& place) const {
    switch (field.kind) {
        case Kind::kText:
            if (!value.is_string()) fail(place, "must be a string, not " + shown(value));
            return value;
        case Kind::kFlag:
            if (!value.is_boolean()) fail(place, "must be true or false, not " + shown(value));
            return value;
        case Kind::kNumber:
            if (!value.is_number()) fail(place, "must be a number, not " + shown(value));
            return value;
        case Kind::kWhole:
            return whole(value, field, place);
        case Kind::kNumbers:
        case Kind::kWholes:
            break;
    }
    if (!value.is_array()) fail(place, "must be an array, not " + shown(value));
    if (field.size != 0 && value.size() != field.size)
        fail(place, "must have " + std::to_string(field.size) + " numbers, not " +
                        std::to_string(value.size()));
    const Field element{field.key, field.kind == Kind::kNumbers ? Kind::kNumber : Kind::kWhole,
                        Need::kRequired, field.refers_to};
    Json array = Json::array();
    for (std::size_t i = 0; i < value.size(); ++i)
        array.push_back(this->value(value[i], element, entry(place, i)));
    return array;
}

// The object with the given fields alone, each as it should be.
Json Checker::object(const Json& from, const std::string& place,
                     std::span<const Field> fields) const {
    if (!from.is_object()) fail(place, "must be an object, not " + shown(from));
    Json clean = Json::object();
    for (const Field& field : fields) {
        const std::string path = place + "." + field.key;
        const auto found = from.find(field.key);
        if (found != from.end()) {
            clean[field.key] = value(*found, field, path);
        } else if (field.need == Need::kRequired) {
            fail(path, "is missing");
        }
    }
    return clean;
}

template <class Clean>
Json Checker::list(const Json& owner, const std::string& place, const char* key,
                   Clean clean) const {
    const std::string path = place.empty() ? key : place + "." + key;
    const auto found = owner.find(key);
    if (found == owner.end()) fail(path, "is missing");
    if (!found->is_array()) fail(path, "must be an array, not " + shown(*found));
    if (found->size() > kMostEntries)
        fail(path, "has too many entries for the memory limit", "split the scene");
    Json array = Json::array();
    for (std::size_t i = 0; i < found->size(); ++i)
        array.push_back(clean((*found)[i], entry(path, i)));
    return array;
}

Json Checker::buffer_view(const Json& from, const std::string& place) const {
    Json clean = object(from, place, kBufferView);
    if (const auto found = clean.find("byteStride"); found != clean.end()) {
        const auto stride = found->get<std::int64_t>();
        if (stride < 4 || stride > 252 || stride % 4 != 0)
            fail(place + ".byteStride", "bufferView's stride " + std::to_string(stride) +
                                            " is not a multiple of 4 from 4 to 252");
    }
    const auto end =
        clean.value("byteOffset", std::int64_t{0}) + clean["byteLength"].get<std::int64_t>();
    const auto& buffer = root_["buffers"].at(clean["buffer"].get<std::size_t>());
    const std::int64_t size = buffer.is_object() && buffer.contains("byteLength")
                                  ? as_whole(buffer["byteLength"]).value_or(0)
                                  : 0;
    if (end > size)
        fail(place, "bufferView ends at byte " + std::to_string(end) + " of a buffer of " +
                        std::to_string(size) + " bytes, out of range");
    return clean;
}

Json Checker::sparse(const Json& from, const std::string& place) const {
    Json clean = object(from, place, kSparse);
    const auto part = [&](const char* key, std::span<const Field> fields) {
        if (!from.contains(key)) fail(place + "." + key, "is missing");
        return object(from[key], place + "." + key, fields);
    };
    clean["indices"] = part("indices", kSparseIndices);
    clean["values"] = part("values", kSparseValues);
    return clean;
}

Json Checker::accessor(const Json& from, const std::string& place) const {
    static constexpr std::array kTypes{"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
    Json clean = object(from, place, kAccessor);
    const auto& type = clean["type"].get_ref<const std::string&>();
    if (std::find(kTypes.begin(), kTypes.end(), type) == kTypes.end())
        fail(place + ".type", "'" + one_line(type, 40) + "' is not a type of an accessor");
    const auto component = clean["componentType"].get<int>();
    if (component < 5120 || component > 5126 || component == 5124)
        fail(place + ".componentType", std::to_string(component) + " is not a type of glTF 2.0");
    if (from.contains("sparse")) clean["sparse"] = sparse(from["sparse"], place + ".sparse");
    return clean;
}

// Only the two attributes that are used go on; the others' references are checked all the same.
Json Checker::primitive(const Json& from, const std::string& place) const {
    Json clean = object(from, place, kPrimitive);
    const std::string path = place + ".attributes";
    if (!from.contains("attributes")) fail(path, "is missing (a primitive needs attributes)");
    if (!from["attributes"].is_object()) fail(path, "must be an object");
    Json attributes = Json::object();
    for (const auto& [key, accessor] : from["attributes"].items()) {
        const Field field{key.c_str(), Kind::kWhole, Need::kRequired, "accessors"};
        const Json index = whole(accessor, field, path + "." + one_line(key, 40));
        if (key == "POSITION" || key == "NORMAL") attributes[key] = index;
    }
    if (clean.contains("indices")) attributes[kIndicesAttribute] = clean["indices"];
    clean.erase("indices");
    clean["attributes"] = std::move(attributes);
    if (clean.value("mode", 4) > 6)
        fail(place + ".mode",
             std::to_string(clean["mode"].get<int>()) + " is not a mode of a primitive (0 to 6)");
    return clean;
}

Json Checker::node(const Json& from, const std::string& place) const {
    Json clean = object(from, place, kNode);
    if (clean.contains("matrix"))
        for (const char* key : {"translation", "rotation", "scale"})
            if (clean.contains(key)) fail(place, std::string("has both matrix and ") + key);
    return clean;
}

Json Checker::contents() const {
    const auto plain = [this](std::span<const Field> fields) {
        return [this, fields](const Json& from, const std::string& place) {
            return object(from, place, fields);
        };
    };
    Json clean = {{"asset", {{"version", "2.0"}}}};
    top_list("buffers", plain(kBuffer));
    clean["bufferViews"] =
        top_list("bufferViews", [this](const auto& j, const auto& p) { return buffer_view(j, p); });
    clean["accessors"] =
        top_list("accessors", [this](const auto& j, const auto& p) { return accessor(j, p); });
    clean["meshes"] = top_list("meshes", [this](const Json& from, const std::string& place) {
        Json mesh = object(from, place, kMesh);
        mesh["primitives"] = list(from, place, "primitives",
                                  [this](const auto& j, const auto& p) { return primitive(j, p); });
        return mesh;
    });
    clean["materials"] = top_list("materials", plain(kMaterial));
    clean["nodes"] = top_list("nodes", [this](const auto& j, const auto& p) { return node(j, p); });
    clean["scenes"] = top_list("scenes", plain(kScene));
    const Field scene{"scene", Kind::kWhole, Need::kOptional, "scenes"};
    if (root_.contains("scene")) clean["scene"] = whole(root_["scene"], scene, "scene");
    return clean;
}

Json Checker::camera(const Json& from, const std::string& place) const {
    Json clean = object(from, place, kCamera);
    const auto type = clean["type"].get<std::string>();
    if (type != "perspective" && type != "orthographic")
        fail(place + ".type",
             "camera type '" + one_line(type, 40) + "' is neither perspective nor orthographic");
    if (!from.contains(type)) fail(place, "camera has no block '" + type + "' with its parameters");
    clean[type] = type == "perspective" ? object(from[type], place + "." + type, kPerspective)
                                        : object(from[type], place + "." + type, kOrthographic);
    const Json& values = clean[type];
    const auto positive = [&](const char* key) {
        if (values.contains(key) && !(values[key].get<double>() > 0))
            fail(place + "." + type + "." + key,
                 "must be greater than 0, not " + values[key].dump());
    };
    for (const char* key : {"yfov", "xmag", "ymag", "zfar", "aspectRatio"}) positive(key);
    if (type == "perspective") positive("znear");
    const double near_plane = values["znear"].get<double>();
    if (near_plane < 0) fail(place + "." + type + ".znear", "must not be negative");
    if (values.contains("zfar") && !(values["zfar"].get<double>() > near_plane))
        fail(place + "." + type + ".zfar", "must be greater than znear");
    if (values.contains("yfov") && !(values["yfov"].get<double>() < 3.14159265358979323846))
        fail(place + "." + type + ".yfov", "must be less than pi (radians)", "give it in radians");
    return clean;
}

Json Checker::cameras() const {
    return top_list("cameras", [this](const auto& j, const auto& p) { return camera(j, p); });
}

}  // namespace

std::optional<std::int64_t> as_whole(const Json& value) {
    const auto in_range = [](auto n) { return n >= 0 && n <= kMostWhole; };
    if (value.is_number_unsigned()) {
        const auto n = value.get<std::uint64_t>();
        if (n <= static_cast<std::uint64_t>(kMostWhole)) return static_cast<std::int64_t>(n);
    } else if (value.is_number_integer()) {
        const auto n = value.get<std::int64_t>();
        if (in_range(n)) return n;
    } else if (value.is_number_float()) {
        const auto x = value.get<double>();
        if (x >= 0 && x <= static_cast<double>(kMostWhole) && x == std::floor(x))
            return static_cast<std::int64_t>(x);
    }
    return std::nullopt;
}

std::string shown(const Json& value) {
    return value.is_structured()
               ? std::string(value.type_name())
               : one_line(value.is_string() ? value.get_ref<const std::string&>() : value.dump(),
                          40);
}

void check_lists(const Json& root) {
    for (const char* key : kLists)
        if (const auto found = root.find(key); found != root.end() && !found->is_array())
            fail(key, "must be an array, not " + shown(*found));
}

Json checked_contents(const Json& root) {
    return Checker(root).contents();
}

Json checked_cameras(const Json& root) {
    return Checker(root).cameras();
}

}  // namespace malus::gltf
