// gltf_front.cpp — opens a glTF file: version, extensions, contents, buffers, in this order.
// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_front.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "io/gltf_container.h"
#include "io/gltf_error.h"
#include "io/gltf_schema.h"

namespace malus::gltf {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 30;  // of a file, and of all buffers together

// A file or BIN chunk may be longer than byteLength; what is beyond is not the buffer's.
std::vector<Bytes> load_buffers(Json& root, std::optional<Bytes> bin,
                                const std::filesystem::path& folder) {
    std::vector<Bytes> buffers;
    std::size_t left = kMostBytes;
    for (std::size_t i = 0; root.contains("buffers") && i < root["buffers"].size(); ++i) {
        const std::string place = entry("buffers", i);
        Json& buffer = root["buffers"][i];
        const auto size = static_cast<std::size_t>(as_whole(buffer["byteLength"]).value_or(0));
        if (size == 0) fail(place + ".byteLength", "must be at least 1, the buffer is empty");
        Bytes bytes;
        if (buffer.contains("uri")) {
            if (!buffer["uri"].is_string()) fail(place + ".uri", "must be a string");
            bytes =
                read_uri(buffer["uri"].get_ref<const std::string&>(), folder, left, place + ".uri");
            buffer.erase("uri");  // may be as large as the data
        } else if (i == 0 && bin) {
            bytes = std::move(*bin);
        } else {
            fail(place, "buffer has no uri, and no BIN chunk of a GLB belongs to it");
        }
        if (bytes.size() < size)
            fail(place + ".byteLength", std::to_string(size) + " exceeds the data's length of " +
                                            std::to_string(bytes.size()) + " bytes");
        bytes.resize(size);
        bytes.shrink_to_fit();
        left -= std::min(left, bytes.size());
        buffers.push_back(std::move(bytes));
    }
    return buffers;
}

// "2.1" → {2, 1}
std::pair<int, int> version_of(const Json& asset, const char* key) {
    const std::string place = std::string("asset.") + key;
    const auto found = asset.find(key);
    if (found == asset.end()) fail(place, "is missing (glTF 1.0, or no glTF at all)");
    if (!found->is_string()) fail(place, "must be a string, not " + shown(*found));
    const auto& text = found->get_ref<const std::string&>();
    int major = 0, minor = 0;
    const char* end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, major);
    const bool dotted = first.ec == std::errc{} && first.ptr != end && *first.ptr == '.';
    const auto second = dotted ? std::from_chars(first.ptr + 1, end, minor) : first;
    if (!dotted || second.ec != std::errc{} || second.ptr != end || major < 0 || minor < 0)
        fail(place, "'" + one_line(text, 40) + "' is not a version like '2.0'");
    return {major, minor};
}

void check_version(const Json& root) {
    const auto asset = root.find("asset");
    if (asset == root.end()) fail("asset", "is missing, so is asset.version");
    if (!asset->is_object()) fail("asset", "must be an object with a version");
    const auto [major, minor] = version_of(*asset, "version");
    if (major != 2)
        fail("asset.version",
             std::to_string(major) + "." + std::to_string(minor) + " is not supported",
             "export it as glTF 2.0");
    if (asset->contains("minVersion") && version_of(*asset, "minVersion") > std::pair{2, 0})
        fail("asset.minVersion", "needs a later version than 2.0", "export it as glTF 2.0");
}

// Extensions that change how a surface looks, never where it is.
bool is_geometry_neutral(const std::string& name) {
    static constexpr std::array kNeutral{"KHR_texture_transform", "KHR_texture_basisu",
                                         "EXT_texture_webp", "KHR_lights_punctual"};
    return name.starts_with("KHR_materials_") ||
           std::find(kNeutral.begin(), kNeutral.end(), name) != kNeutral.end();
}

void check_extensions(const Json& root, Document& document) {
    const auto each = [&](const char* key, auto visit) {
        for (std::size_t i = 0; root.contains(key) && i < root[key].size(); ++i) {
            if (!root[key][i].is_string()) fail(entry(key, i), "must be a string");
            visit(root[key][i].get_ref<const std::string&>());
        }
    };
    const auto known = [&](const std::string& name) {
        if (name == "KHR_mesh_quantization") document.quantized = true;
        return name == "KHR_mesh_quantization" || is_geometry_neutral(name);
    };
    each("extensionsRequired", [&](const std::string& name) {
        if (!known(name))
            fail("extensionsRequired", "extension '" + one_line(name) + "' is not supported",
                 "export the scene without it");
    });
    each("extensionsUsed", [&](const std::string& name) {
        if (!known(name) && document.warnings.size() < 100)
            document.warnings.push_back("extension '" + one_line(name) + "' is not used");
    });
}

// Also counts primitives and keeps the names of the materials.
void note_contents(const Json& root, const Json& clean, Document& document) {
    const auto warn_of = [&](const char* key, const char* text) {
        if (root.contains(key) && !root[key].empty()) document.warnings.push_back(text);
    };
    warn_of("images", "textures are not used");
    warn_of("animations", "animations are not used: nodes stay where they are placed");
    warn_of("skins", "skins are not applied: skinned meshes stay in their bind pose");
    bool morphs = false;
    for (std::size_t i = 0; i < clean["meshes"].size(); ++i) {
        document.primitives += clean["meshes"][i]["primitives"].size();
        for (const Json& primitive : root["meshes"][i]["primitives"])
            morphs = morphs || primitive.contains("targets");
    }
    if (document.primitives > kMostEntries)
        fail("meshes", "have too many primitives for the memory limit", "split the scene");
    if (morphs) document.warnings.push_back("morph targets are not applied");
    for (const Json& material : clean["materials"])
        document.materials.push_back(material.value("name", ""));
}

Json parsed(const std::string& text) {
    try {
        Json root = Json::parse(text);
        if (!root.is_object()) fail("JSON", "root must be an object, not " + shown(root));
        return root;
    } catch (const Json::exception& error) {
        const std::string reason = error.what();  // "[json.exception…] parse error at line …"
        const std::size_t begin = reason.find("] ");
        fail("JSON", "cannot be parsed, or is not a glTF file (" +
                         one_line(begin == std::string::npos ? reason : reason.substr(begin + 2)) +
                         ")");
    }
}

Json buffers_by_name(const std::vector<Bytes>& buffers) {
    Json list = Json::array();
    for (std::size_t i = 0; i < buffers.size(); ++i)
        list.push_back(
            {{"uri", kBufferName + std::to_string(i)}, {"byteLength", buffers[i].size()}});
    return list;
}

}  // namespace

Document read_document(const std::filesystem::path& path) {
    Container container = open_container(read_regular_file(path, kMostBytes, ""));
    Json root = parsed(std::exchange(container.text, {}));
    Document document;
    check_version(root);
    check_lists(root);
    check_extensions(root, document);
    Json clean = checked_contents(root);
    note_contents(root, clean, document);
    clean.erase("materials");  // costly in the library, and all of them that counts are the names
    document.buffers = load_buffers(root, std::move(container.bin), path.parent_path());
    clean["buffers"] = buffers_by_name(document.buffers);
    clean["cameras"] = checked_cameras(root);
    document.json = clean.dump();
    return document;
}

}  // namespace malus::gltf
