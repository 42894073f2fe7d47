// gltf.cpp — from glTF's lists of nodes, meshes and accessors to a Scene.
//
//   to_world of a node = to_world of its parent · (matrix, or T·R·S)
//
// Order   gltf_front has checked the JSON; here follow the checks that need the hierarchy or data.
// Memory  what is decoded is counted against a budget before it is allocated.
// Source  glTF 2.0 specification, §3.5 (nodes), §3.7 (meshes), §3.10 (cameras).
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/gltf.h"

#include <tiny_gltf.h>

#include <cfloat>
#include <map>
#include <optional>

#include "io/gltf_accessor.h"
#include "io/gltf_error.h"
#include "io/gltf_front.h"
#include "io/gltf_triangles.h"

namespace malus {
namespace {

using namespace gltf;

constexpr std::size_t kMostDecodedBytes = std::size_t{1} << 30;
constexpr std::size_t kMostInstances = 2'000'000;
constexpr std::size_t kMostWarnings = 100;

// Which buffer the library means by "./malus-buffer-3"; none if it asks for anything else.
Bytes* find_buffer(const std::string& path, void* document) {
    auto& buffers = static_cast<Document*>(document)->buffers;
    const std::size_t at = path.rfind(kBufferName);
    if (at == std::string::npos) return nullptr;
    const std::size_t i = std::stoul(path.substr(at + std::string(kBufferName).size()));
    return i < buffers.size() ? &buffers[i] : nullptr;
}

tinygltf::FsCallbacks memory_only(Document& document) {
    tinygltf::FsCallbacks callbacks{};
    callbacks.FileExists = [](const std::string& path, void* data) {
        return find_buffer(path, data) != nullptr;
    };
    callbacks.ExpandFilePath = [](const std::string& path, void*) { return path; };
    callbacks.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*,
                                 const std::string& path, void* data) {
        Bytes* buffer = find_buffer(path, data);
        if (buffer != nullptr) *out = std::move(*buffer);
        return buffer != nullptr;
    };
    callbacks.WriteWholeFile = [](std::string*, const std::string&,
                                  const std::vector<unsigned char>&, void*) { return false; };
    callbacks.user_data = &document;
    return callbacks;
}

tinygltf::Model parsed_model(Document& document) {
    tinygltf::TinyGLTF loader;
    loader.SetFsCallbacks(memory_only(document));
    tinygltf::Model model;
    std::string error, warning;
    const bool loaded = loader.LoadASCIIFromString(&model, &error, &warning, document.json.data(),
                                                   static_cast<unsigned>(document.json.size()), "",
                                                   tinygltf::REQUIRE_VERSION);
    if (!loaded) fail("", "is not accepted by the glTF library (" + one_line(error) + ")");
    std::size_t primitives = 0;
    for (const tinygltf::Mesh& mesh : model.meshes) primitives += mesh.primitives.size();
    if (primitives != document.primitives)  // it drops what it cannot parse without a word
        fail("meshes", "some primitives are not accepted by the glTF library");
    return model;
}

Affine matrix_placement(const std::vector<double>& m, const std::string& place) {
    for (const auto& [i, wanted] : {std::pair{3, 0.0}, {7, 0.0}, {11, 0.0}, {15, 1.0}})
        if (!(std::abs(m[static_cast<std::size_t>(i)] - wanted) < 1e-6))
            fail(place + ".matrix", "its last row is not 0 0 0 1 (perspective is not placement)");
    return {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
}

// The columns of the rotation by the quaternion q = (x, y, z, w), which need not be unit.
Affine rotation(const std::vector<double>& q, const std::string& place) {
    const double most = std::max({std::abs(q[0]), std::abs(q[1]), std::abs(q[2]), std::abs(q[3])});
    if (!(most > 0)) fail(place + ".rotation", "quaternion is zero and turns nowhere");
    double x = q[0] / most, y = q[1] / most, z = q[2] / most, w = q[3] / most;
    const double norm = std::sqrt(x * x + y * y + z * z + w * w);
    x /= norm, y /= norm, z /= norm, w /= norm;
    return {{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
            {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
            {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)},
            {0, 0, 0}};
}

Affine local_placement(const tinygltf::Node& node, const std::string& place) {
    if (!node.matrix.empty()) return matrix_placement(node.matrix, place);
    Affine placement = node.rotation.empty() ? Affine{} : rotation(node.rotation, place);
    if (!node.scale.empty()) {
        placement.x = node.scale[0] * placement.x;
        placement.y = node.scale[1] * placement.y;
        placement.z = node.scale[2] * placement.z;
    }
    if (!node.translation.empty())
        placement.t = {node.translation[0], node.translation[1], node.translation[2]};
    return placement;
}

bool is_finite(const Affine& a) {
    return malus::is_finite(a.x) && malus::is_finite(a.y) && malus::is_finite(a.z) &&
           malus::is_finite(a.t);
}

// Axes stay as near to the node's as lens and picture allow: the view along −z exactly, up in the
// plane of y and z. right follows from those, so that a mirrored node does not mirror the picture.
Camera placed_camera(const tinygltf::Camera& from, const tinygltf::Node& node,
                     const Affine& to_world, const std::string& place) {
    Camera camera;
    camera.name = from.name.empty() ? node.name : from.name;
    camera.position = to_world.t;
    const double z_length = length(to_world.z);
    if (!(z_length > 0) || !std::isfinite(z_length))
        fail(place, "camera's node has a scale of zero or infinity and so no view direction");
    camera.forward = -to_world.z / z_length;
    const double y_length = length(to_world.y);
    const Vec3 y = to_world.y / y_length;
    const Vec3 up = y - dot(y, camera.forward) * camera.forward;
    if (!std::isfinite(y_length) || !(length(up) > 1e-9))
        fail(place, "camera's node has a scale or shear that leaves no up direction");
    camera.up = normalize(up);
    camera.right = cross(camera.forward, camera.up);
    if (from.type == "perspective") {
        camera.projection = Projection::kPerspective;
        camera.yfov = from.perspective.yfov;
    } else {
        camera.projection = Projection::kOrthographic;
        camera.xmag = from.orthographic.xmag;
        camera.ymag = from.orthographic.ymag;
    }
    return camera;
}

// What a glTF mesh has become: consecutive entries of Scene::meshes.
struct MeshRange {
    std::size_t begin = 0, end = 0;
};

struct Visit {
    int node;
    Affine parent_to_world;
};

class Builder {
  public:
    Builder(const tinygltf::Model& model, bool quantized) : model_(model), quantized_(quantized) {}

    void link_nodes();
    void place_nodes();
    Scene take() { return std::move(scene_); }
    void warn(const std::string& text) {
        if (scene_.warnings.size() < kMostWarnings) scene_.warnings.push_back(text);
    }

  private:
    std::vector<int> roots() const;
    void place(int node, const Affine& to_world);
    const MeshRange& built_mesh(int mesh);
    void build_primitive(const tinygltf::Primitive& from, const std::string& name,
                         const std::string& place);
    std::vector<std::uint32_t> indices_of(const tinygltf::Primitive& from, std::size_t vertices,
                                          const std::string& place);
    std::optional<Accessor> find_accessor(const tinygltf::Primitive& from, const char* attribute);
    void check_vectors(const Accessor& accessor, const char* attribute) const;
    void read_normals(const tinygltf::Primitive& from, const std::string& place, Mesh& mesh);
    BufferSlice slice_of(int buffer_view, std::size_t offset) const;
    void spend(std::size_t count, std::size_t size, const std::string& place);

    const tinygltf::Model& model_;
    bool quantized_;
    Scene scene_;
    std::size_t bytes_left_ = kMostDecodedBytes;
    std::map<int, MeshRange> ranges_;
    std::vector<Box> boxes_;  // of Scene::meshes, each in its own coordinates
};

// Every node has at most one parent and none is its own ancestor, whichever scene it is in.
void Builder::link_nodes() {
    scene_.nodes.resize(model_.nodes.size());
    for (std::size_t i = 0; i < model_.nodes.size(); ++i) {
        scene_.nodes[i].name = model_.nodes[i].name;
        for (const int child : model_.nodes[i].children) {
            int& parent = scene_.nodes[static_cast<std::size_t>(child)].parent;
            if (parent >= 0)
                fail(entry("nodes", static_cast<std::size_t>(child)),
                     "is a child twice, of the nodes " + std::to_string(parent) + " and " +
                         std::to_string(i) + " (the hierarchy must be a tree)");
            parent = static_cast<int>(i);
        }
    }
    // With one parent each, nodes that no root leads to are on or below a cycle.
    std::vector<int> pending;
    for (std::size_t i = 0; i < scene_.nodes.size(); ++i)
        if (scene_.nodes[i].parent < 0) pending.push_back(static_cast<int>(i));
    std::size_t reached = 0;
    while (!pending.empty()) {
        const auto& children = model_.nodes[static_cast<std::size_t>(pending.back())].children;
        pending.pop_back();
        ++reached;
        pending.insert(pending.end(), children.begin(), children.end());
    }
    if (reached != scene_.nodes.size())
        fail("nodes", "hierarchy has a cycle: a node is its own parent or ancestor");
}

std::vector<int> Builder::roots() const {
    std::vector<int> nodes;
    if (model_.scenes.empty()) {
        for (std::size_t i = 0; i < scene_.nodes.size(); ++i)
            if (scene_.nodes[i].parent < 0) nodes.push_back(static_cast<int>(i));
        return nodes;
    }
    const auto used = static_cast<std::size_t>(std::max(model_.defaultScene, 0));
    std::vector<bool> listed(scene_.nodes.size());
    for (const int node : model_.scenes[used].nodes) {
        const auto i = static_cast<std::size_t>(node);
        if (scene_.nodes[i].parent >= 0)
            fail(entry("scenes", used) + ".nodes",
                 "node " + std::to_string(node) + " is not a root (it has a parent)");
        if (listed[i])
            fail(entry("scenes", used) + ".nodes",
                 "root node " + std::to_string(node) + " is listed twice");
        listed[i] = true;
        nodes.push_back(node);
    }
    return nodes;
}

// Depth first, children in their order. A stack of our own: a chain of nodes can be long.
void Builder::place_nodes() {
    std::vector<Visit> pending;
    const std::vector<int> first = roots();
    for (auto root = first.rbegin(); root != first.rend(); ++root)
        pending.push_back({*root, Affine{}});
    while (!pending.empty()) {
        const Visit visit = pending.back();
        pending.pop_back();
        const auto i = static_cast<std::size_t>(visit.node);
        const Affine to_world =
            visit.parent_to_world * local_placement(model_.nodes[i], entry("nodes", i));
        if (!is_finite(to_world)) fail(entry("nodes", i), "its placement is not finite");
        place(visit.node, to_world);
        const auto& children = model_.nodes[i].children;
        for (auto child = children.rbegin(); child != children.rend(); ++child)
            pending.push_back({*child, to_world});
    }
}

// Adds the node's camera and instances of its mesh.
void Builder::place(int node, const Affine& to_world) {
    const auto i = static_cast<std::size_t>(node);
    const tinygltf::Node& from = model_.nodes[i];
    if (from.camera >= 0)
        scene_.cameras.push_back(
            placed_camera(model_.cameras[static_cast<std::size_t>(from.camera)], from, to_world,
                          entry("nodes", i)));
    if (from.mesh < 0) return;
    const MeshRange& range = built_mesh(from.mesh);
    if (range.end - range.begin > kMostInstances - scene_.instances.size())
        fail("nodes", "place too many instances for the memory limit", "split the scene");
    for (std::size_t mesh = range.begin; mesh < range.end; ++mesh) {
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 p = to_world.point(boxes_[mesh].corner(corner));
            const double most = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
            if (!(most < FLT_MAX)) fail(entry("nodes", i), "mesh is placed out of finite range");
        }
        scene_.instances.push_back({static_cast<int>(mesh), node, to_world});
    }
}

const MeshRange& Builder::built_mesh(int mesh) {
    const auto [found, is_new] = ranges_.try_emplace(mesh);
    if (!is_new) return found->second;
    const auto i = static_cast<std::size_t>(mesh);
    found->second.begin = scene_.meshes.size();
    const tinygltf::Mesh& from = model_.meshes[i];
    for (std::size_t k = 0; k < from.primitives.size(); ++k)
        build_primitive(from.primitives[k], from.name,
                        entry("meshes", i) + "." + entry("primitives", k));
    found->second.end = scene_.meshes.size();
    return found->second;
}

void Builder::build_primitive(const tinygltf::Primitive& from, const std::string& name,
                              const std::string& place) {
    if (from.mode < 4) return warn(place + ": points or lines are skipped");
    const auto positions = find_accessor(from, "POSITION");
    if (!positions) return warn(place + ": has no POSITION and is skipped");
    check_vectors(*positions, "POSITION");
    const auto topology = static_cast<Topology>(from.mode);
    spend(positions->count, sizeof(Vec3f), positions->place);
    Mesh mesh{name, from.material, read_vectors(*positions), {}, {}};
    Box box;
    for (const Vec3f& p : mesh.positions) {
        if (!malus::is_finite(p)) fail(positions->place, "POSITION is NaN or not finite");
        box.add(Vec3(p));
    }
    const auto indices = indices_of(from, mesh.positions.size(), place);
    const std::size_t corners = indices.empty() ? mesh.positions.size() : indices.size();
    if (topology == Topology::kTriangles && corners % 3 != 0)
        fail(place, std::to_string(corners) + " vertices or indices do not divide into triangles");
    const std::size_t count = count_triangles(topology, corners);
    if (count == 0) return warn(place + ": has less than 3 vertices and is skipped");
    spend(count, sizeof(Triangle), place);
    mesh.triangles = make_triangles(topology, corners, indices);
    read_normals(from, place, mesh);
    scene_.meshes.push_back(std::move(mesh));
    boxes_.push_back(box);
}

// Empty when the primitive has none: its vertices are then used in their order.
std::vector<std::uint32_t> Builder::indices_of(const tinygltf::Primitive& from,
                                               std::size_t vertices, const std::string& place) {
    const auto accessor = find_accessor(from, kIndicesAttribute);
    if (!accessor) return {};
    if (accessor->components != 1 ||
        (accessor->type != Component::kUint8 && accessor->type != Component::kUint16 &&
         accessor->type != Component::kUint32))
        fail(accessor->place, "type or componentType does not suit indices (unsigned SCALAR)");
    check_ranges(*accessor);
    spend(accessor->count, sizeof(std::uint32_t), accessor->place);
    std::vector<std::uint32_t> indices = read_integers(*accessor);
    for (const std::uint32_t index : indices) {
        if (index == largest(accessor->type))
            fail(place, "index " + std::to_string(index) + " means restart, which is not allowed");
        if (index >= vertices)
            fail(place, "index " + std::to_string(index) + " is out of range (there are " +
                            std::to_string(vertices) + " vertices)");
    }
    bytes_left_ += accessor->count * sizeof(std::uint32_t);  // they are not kept
    return indices;
}

void Builder::read_normals(const tinygltf::Primitive& from, const std::string& place, Mesh& mesh) {
    const auto normals = find_accessor(from, "NORMAL");
    if (!normals) return;
    check_vectors(*normals, "NORMAL");
    if (normals->count != mesh.positions.size())
        fail(place, "NORMAL has a count of " + std::to_string(normals->count) + ", POSITION of " +
                        std::to_string(mesh.positions.size()));
    spend(normals->count, sizeof(Vec3f), normals->place);
    mesh.normals = read_vectors(*normals);
    const std::size_t replaced = unify_normals(mesh.positions, mesh.triangles, mesh.normals);
    if (replaced > 0)
        warn(place + ": " + std::to_string(replaced) +
             " normals are zero or not finite and were made from the triangles around them");
}

// Types as in glTF 2.0 §3.7.2.1, and as in KHR_mesh_quantization where the file asks for it.
void Builder::check_vectors(const Accessor& accessor, const char* attribute) const {
    const bool position = std::string(attribute) == "POSITION";
    if (accessor.components != 3)
        fail(accessor.place + ".type", std::string("must be VEC3 for ") + attribute);
    const bool is_signed = accessor.type == Component::kInt8 || accessor.type == Component::kInt16;
    const bool is_small =
        is_signed || accessor.type == Component::kUint8 || accessor.type == Component::kUint16;
    const bool allowed = position ? is_small : is_signed && accessor.normalized;
    if (accessor.type != Component::kFloat && !(quantized_ && allowed))
        fail(accessor.place + ".componentType",
             "type " + std::to_string(static_cast<int>(accessor.type)) + " does not suit " +
                 attribute + (quantized_ ? "" : " without KHR_mesh_quantization"));
    check_ranges(accessor);
}

std::optional<Accessor> Builder::find_accessor(const tinygltf::Primitive& from,
                                               const char* attribute) {
    const auto found = from.attributes.find(attribute);
    if (found == from.attributes.end()) return std::nullopt;
    const auto i = static_cast<std::size_t>(found->second);
    const tinygltf::Accessor& source = model_.accessors[i];
    Accessor accessor;
    accessor.place = entry("accessors", i);
    accessor.type = static_cast<Component>(source.componentType);
    accessor.normalized = source.normalized;
    accessor.components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(source.type));
    accessor.count = source.count;
    if (source.bufferView >= 0) accessor.view = slice_of(source.bufferView, source.byteOffset);
    if (source.sparse.isSparse) {
        const auto& sparse = source.sparse;
        accessor.sparse = Sparse{
            static_cast<std::uint64_t>(sparse.count),
            static_cast<Component>(sparse.indices.componentType),
            slice_of(sparse.indices.bufferView,
                     static_cast<std::size_t>(sparse.indices.byteOffset)),
            slice_of(sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset))};
        accessor.sparse->indices.stride = accessor.sparse->values.stride = 0;  // always packed
    }
    return accessor;
}

BufferSlice Builder::slice_of(int buffer_view, std::size_t offset) const {
    const tinygltf::BufferView& view = model_.bufferViews[static_cast<std::size_t>(buffer_view)];
    const Bytes& buffer = model_.buffers[static_cast<std::size_t>(view.buffer)].data;
    return {std::span(buffer).subspan(view.byteOffset, view.byteLength), offset, view.byteStride};
}

void Builder::spend(std::size_t count, std::size_t size, const std::string& place) {
    if (count > bytes_left_ / size)
        fail(place,
             "a count of " + std::to_string(count) + " is too large for the memory limit of " +
                 std::to_string(kMostDecodedBytes >> 20) + " MiB",
             "split the scene");
    bytes_left_ -= count * size;
}

Scene built_scene(Document document) {
    const tinygltf::Model model = parsed_model(document);
    Builder builder(model, document.quantized);
    for (const std::string& warning : document.warnings) builder.warn(warning);
    builder.link_nodes();
    builder.place_nodes();
    Scene scene = builder.take();
    scene.surfaces = std::move(document.materials);
    if (scene.instances.empty()) {
        std::string reason;
        for (const std::string& warning : scene.warnings)
            if (warning.starts_with("meshes[")) reason = " (" + warning + ")";
        fail("scene", "holds no triangle" + reason, "export a scene with meshes");
    }
    return scene;
}

}  // namespace

Scene read_gltf(const std::filesystem::path& path) {
    const std::string file = one_line(path.string(), 4096);
    try {
        return built_scene(read_document(path));
    } catch (const Error& error) {
        throw Error(file + ": " + error.what());
    } catch (const std::exception& error) {
        throw Error(file + ": cannot be read (" + one_line(error.what()) +
                    "); re-export the scene");
    }
}

}  // namespace malus
