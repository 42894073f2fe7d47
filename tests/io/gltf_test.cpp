// gltf_test.cpp — glTF scenes as the specification means them, and hostile ones.
//
// Small scenes are written here byte by byte; expected numbers are worked out by hand beside them.
// The walk over data/gltf/expected.csv takes its numbers from that file (made by another reader).
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/gltf.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "malus/core/error.h"
#include "support/catch.h"

#ifndef MALUS_SHARED_DATA
#define MALUS_SHARED_DATA ""
#endif

namespace {

namespace fs = std::filesystem;
using malus::Affine;
using malus::Box;
using malus::Camera;
using malus::Error;
using malus::read_gltf;
using malus::Scene;
using malus::Vec3;
using malus::Vec3f;

class TempFolder {
  public:
    TempFolder() {
        std::string name = (fs::temp_directory_path() / "malus-gltf-XXXXXX").string();
        REQUIRE(::mkdtemp(name.data()) != nullptr);
        path_ = name;
    }
    ~TempFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    TempFolder(const TempFolder&) = delete;
    TempFolder& operator=(const TempFolder&) = delete;

    fs::path path() const { return path_; }
    fs::path write(const std::string& name, const std::string& bytes) const {
        fs::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << bytes;
        return path_ / name;
    }

  private:
    fs::path path_;
};

template <class T>
std::string bytes_of(std::initializer_list<T> values) {
    std::string bytes;
    for (const T value : values) {
        char raw[sizeof(T)];
        std::memcpy(raw, &value, sizeof(T));
        bytes.append(raw, sizeof(T));
    }
    return bytes;
}

std::string base64(const std::string& bytes) {
    static const char* const kAlphabet =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned word = 0;
        for (std::size_t k = 0; k < 3; ++k)
            word =
                word << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k <= bytes.size() ? kAlphabet[word >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

std::string glb(std::string json, std::string bin) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    bin.resize((bin.size() + 3) / 4 * 4, '\0');
    const auto size = [](std::size_t n) { return static_cast<std::uint32_t>(n); };
    return "glTF" + bytes_of<std::uint32_t>({2, size(28 + json.size() + bin.size())}) +
           bytes_of<std::uint32_t>({size(json.size()), 0x4E4F534A}) + json +
           bytes_of<std::uint32_t>({size(bin.size()), 0x004E4942}) + bin;
}

// A scene of one buffer. Each block starts on a multiple of 4 bytes in a bufferView of its own.
struct Draft {
    std::string nodes = R"([{"mesh":0}])";
    std::string primitive = R"({"attributes":{"POSITION":0}})";
    std::string roots = "0";
    std::string more;  // members of the root, each with a comma in front
    std::string views, accessors, data, uri;
    int view_count = 0;

    int view(const std::string& bytes, const std::string& members = "") {
        data.resize((data.size() + 3) / 4 * 4, '\0');
        views += (view_count ? "," : "") + std::string(R"({"buffer":0,"byteOffset":)") +
                 std::to_string(data.size()) + R"(,"byteLength":)" + std::to_string(bytes.size()) +
                 members + "}";
        data += bytes;
        return view_count++;
    }
    Draft& accessor(const std::string& members) {
        accessors += (accessors.empty() ? "{" : ",{") + members + "}";
        return *this;
    }
    Draft& typed(const std::string& bytes, int component, int count, const std::string& type,
                 const std::string& members = "") {
        return accessor(R"("bufferView":)" + std::to_string(view(bytes)) + R"(,"componentType":)" +
                        std::to_string(component) + R"(,"count":)" + std::to_string(count) +
                        R"(,"type":")" + type + "\"" + members);
    }
    Draft& points(std::initializer_list<float> xyz) {
        return typed(bytes_of(xyz), 5126, static_cast<int>(xyz.size() / 3), "VEC3");
    }
    std::string json(const std::string& uri_member) const {
        return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[)" + roots + R"(]}],"nodes":)" +
               nodes + R"(,"meshes":[{"name":"m","primitives":[)" + primitive +
               R"(]}],"accessors":[)" + accessors + R"(],"bufferViews":[)" + views +
               R"(],"buffers":[{"byteLength":)" + std::to_string(data.size()) + uri_member + "}]" +
               more + "}";
    }
    std::string embedded() const {
        return json(R"(,"uri":"data:application/octet-stream;base64,)" + base64(data) + "\"");
    }
};

const std::initializer_list<float> kCorner = {0, 0, 0, 1, 0, 0, 0, 1, 0};
const std::initializer_list<float> kSquare = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};

Scene read_text(const std::string& text) {
    const TempFolder folder;
    return read_gltf(folder.write("scene.gltf", text));
}
Scene read_draft(const Draft& draft) {
    return read_text(draft.embedded());
}

std::string message_of(const fs::path& path) {
    try {
        read_gltf(path);
    } catch (const Error& error) {
        return error.what();
    }
    return "no error";
}
std::string message_of_text(const std::string& text) {
    const TempFolder folder;
    return message_of(folder.write("scene.gltf", text));
}
std::string message_of_draft(const Draft& draft) {
    return message_of_text(draft.embedded());
}

bool near(const Vec3& a, const Vec3& b, double most = 1e-6) {
    return malus::length(a - b) <= most;
}

Catch::Matchers::StdString::ContainsMatcher has(const std::string& text) {
    return Catch::Matchers::Contains(text);
}

double area_of(const Scene& scene) {
    double area = 0;
    for (const auto& instance : scene.instances) {
        const auto& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
        for (const auto& t : mesh.triangles) {
            const Vec3 a = instance.to_world.point(Vec3(mesh.positions[t[0]]));
            const Vec3 b = instance.to_world.point(Vec3(mesh.positions[t[1]]));
            const Vec3 c = instance.to_world.point(Vec3(mesh.positions[t[2]]));
            area += 0.5 * malus::length(malus::cross(b - a, c - a));
        }
    }
    return area;
}

}  // namespace

TEST_CASE("A triangle without indices uses its vertices in order") {
    const Scene scene = read_draft(Draft().points(kCorner));
    REQUIRE(scene.meshes.size() == 1);
    CHECK(scene.meshes[0].name == "m");
    CHECK(scene.meshes[0].surface == -1);
    CHECK(scene.meshes[0].normals.empty());
    CHECK(scene.meshes[0].positions[1] == Vec3f(1, 0, 0));
    CHECK(scene.meshes[0].triangles == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}});
}

TEST_CASE("Indices of one, two and four bytes name the same triangle") {
    Draft draft = Draft().points(kCorner);
    draft.primitive = R"({"attributes":{"POSITION":0},"indices":1})";
    SECTION("one byte") {
        draft.typed(bytes_of<std::uint8_t>({2, 0, 1}), 5121, 3, "SCALAR");
    }
    SECTION("two bytes") {
        draft.typed(bytes_of<std::uint16_t>({2, 0, 1}), 5123, 3, "SCALAR");
    }
    SECTION("four bytes") {
        draft.typed(bytes_of<std::uint32_t>({2, 0, 1}), 5125, 3, "SCALAR");
    }
    const Scene scene = read_draft(draft);
    CHECK(scene.meshes[0].triangles[0] == std::array<std::uint32_t, 3>{2, 0, 1});
}

TEST_CASE("An index that means restart, or none of the vertices, is refused") {
    Draft draft = Draft().points(kCorner);
    draft.primitive = R"({"attributes":{"POSITION":0},"indices":1})";
    SECTION("restart") {
        draft.typed(bytes_of<std::uint16_t>({0, 1, 65535}), 5123, 3, "SCALAR");
        CHECK_THAT(message_of_draft(draft), has("restart"));
    }
    SECTION("out of range") {
        draft.typed(bytes_of<std::uint16_t>({0, 1, 3}), 5123, 3, "SCALAR");
        CHECK_THAT(message_of_draft(draft),
                   has("meshes[0].primitives[0]: index 3 is out of range"));
    }
    SECTION("not an integer") {
        draft.typed(bytes_of<float>({0, 1, 2}), 5126, 3, "SCALAR");
        CHECK_THAT(message_of_draft(draft), has("does not suit indices"));
    }
}

TEST_CASE("A strip turns every second triangle around so that all face the same side") {
    Draft draft = Draft().points(kSquare);  // in the order of a strip, facing +z
    draft.primitive = R"({"attributes":{"POSITION":0},"mode":5})";
    const auto mesh = read_draft(draft).meshes.at(0);
    REQUIRE(mesh.triangles.size() == 2);
    CHECK(mesh.triangles[0] == std::array<std::uint32_t, 3>{0, 1, 2});
    CHECK(mesh.triangles[1] == std::array<std::uint32_t, 3>{1, 3, 2});
}

TEST_CASE("A fan's triangles share its first vertex") {
    Draft draft = Draft().points({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    draft.primitive = R"({"attributes":{"POSITION":0},"mode":6})";
    const Scene scene = read_draft(draft);
    REQUIRE(scene.meshes[0].triangles.size() == 2);
    CHECK(scene.meshes[0].triangles[1] == std::array<std::uint32_t, 3>{2, 3, 0});
    CHECK(area_of(scene) == Approx(1.0));
}

TEST_CASE("Points and lines are skipped with a warning and do not make a scene") {
    Draft draft = Draft().points(kCorner);
    draft.primitive = R"({"attributes":{"POSITION":0},"mode":0},{"attributes":{"POSITION":0}})";
    const Scene scene = read_draft(draft);
    CHECK(scene.meshes.size() == 1);
    REQUIRE(scene.warnings.size() == 1);
    CHECK_THAT(scene.warnings[0], has("meshes[0].primitives[0]"));
    draft.primitive = R"({"attributes":{"POSITION":0},"mode":3})";
    CHECK_THAT(message_of_draft(draft), has("triangle"));
}

TEST_CASE("Sparse values replace single vertices, over data or over zeros") {
    const bool over_data = GENERATE(true, false);
    Draft draft;
    const int base = draft.view(bytes_of(kCorner));
    const int indices = draft.view(bytes_of<std::uint8_t>({0, 2}));
    const int values = draft.view(bytes_of<float>({0, 0, 5, 0, 3, 5}));
    draft.accessor((over_data ? R"("bufferView":)" + std::to_string(base) + "," : "") +
                   R"("componentType":5126,"count":3,"type":"VEC3","sparse":{"count":2,)" +
                   R"("indices":{"bufferView":)" + std::to_string(indices) +
                   R"(,"componentType":5121},"values":{"bufferView":)" + std::to_string(values) +
                   "}}");
    const auto positions = read_draft(draft).meshes.at(0).positions;
    CHECK(positions[0] == Vec3f(0, 0, 5));
    CHECK(positions[1] == Vec3f(over_data ? 1 : 0, 0, 0));
    CHECK(positions[2] == Vec3f(0, 3, 5));
}

TEST_CASE("An index accessor may be sparse and have no bufferView") {
    Draft draft = Draft().points(kCorner);
    draft.primitive = R"({"attributes":{"POSITION":0},"indices":1})";
    draft.view(bytes_of<std::uint8_t>({1, 2}));
    draft.view(bytes_of<std::uint16_t>({1, 2}));
    draft.accessor(R"("componentType":5123,"count":3,"type":"SCALAR","sparse":{"count":2,)"
                   R"("indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":2}})");
    CHECK(read_draft(draft).meshes.at(0).triangles[0] == std::array<std::uint32_t, 3>{0, 1, 2});
}

TEST_CASE("Sparse indices must increase and stay in range") {
    const auto with = [](std::uint8_t first, std::uint8_t second) {
        Draft draft = Draft();
        draft.view(bytes_of<std::uint8_t>({first, second}));
        draft.view(bytes_of<float>({0, 0, 0, 1, 1, 1}));
        draft.accessor(
            R"("componentType":5126,"count":3,"type":"VEC3","sparse":{"count":2,)"
            R"("indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":1}})");
        return message_of_draft(draft);
    };
    CHECK_THAT(with(0, 3), has("accessors[0].sparse: index 3 is out of range"));
    CHECK_THAT(with(1, 1), has("does not increase"));
}

TEST_CASE("KHR_mesh_quantization: integers become floats, normalized ones over their largest") {
    Draft draft;
    draft.more = R"(,"extensionsUsed":["KHR_mesh_quantization"])"
                 R"(,"extensionsRequired":["KHR_mesh_quantization"])";
    const auto positions = [&] { return read_draft(draft).meshes.at(0).positions; };
    SECTION("int8, normalized: max(c/127, −1)") {
        draft.typed(bytes_of<std::int8_t>({127, 0, -128, 0, -127, 0, 0, 0, 0}), 5120, 3, "VEC3",
                    R"(,"normalized":true)");
        CHECK(positions()[0] == Vec3f(1, 0, -1));
        CHECK(positions()[1] == Vec3f(0, -1, 0));
    }
    SECTION("uint16, normalized: c/65535") {
        draft.typed(bytes_of<std::uint16_t>({65535, 0, 13107, 0, 0, 0, 0, 65535, 0}), 5123, 3,
                    "VEC3", R"(,"normalized":true)");
        CHECK(near(Vec3(positions()[0]), {1, 0, 0.2}));
    }
    SECTION("int16, as it is") {
        draft.typed(bytes_of<std::int16_t>({-300, 7, 0, 0, 0, 0, 0, 1, 0}), 5122, 3, "VEC3");
        CHECK(positions()[0] == Vec3f(-300, 7, 0));
    }
}

TEST_CASE("Integer positions without KHR_mesh_quantization are refused") {
    Draft draft;
    draft.typed(bytes_of<std::int16_t>({0, 0, 0, 1, 0, 0, 0, 1, 0}), 5122, 3, "VEC3");
    CHECK_THAT(message_of_draft(draft), has("KHR_mesh_quantization"));
}

TEST_CASE("Interleaved positions and normals are told apart by byteStride and byteOffset") {
    Draft draft;
    draft.view(bytes_of<float>({0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0}),
               R"(,"byteStride":24)");
    for (const char* offset : {"0", "12"})
        draft.accessor(R"("bufferView":0,"byteOffset":)" + std::string(offset) +
                       R"(,"componentType":5126,"count":3,"type":"VEC3")");
    draft.primitive = R"({"attributes":{"POSITION":0,"NORMAL":1}})";
    const auto mesh = read_draft(draft).meshes.at(0);
    CHECK(mesh.positions == std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    CHECK(mesh.normals == std::vector<Vec3f>{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}});
}

TEST_CASE("An accessor that ends one byte beyond its bufferView is refused with both numbers") {
    Draft draft;
    draft.view(bytes_of(kCorner));  // 36 bytes
    draft.accessor(R"("bufferView":0,"byteOffset":1,"componentType":5126,"count":3,"type":"VEC3")");
    CHECK_THAT(message_of_draft(draft),
               has("accessors[0]: reads to byte 37 of a bufferView of 36"));
}

TEST_CASE("A whole number may be written as a float, no other number may") {
    Draft draft;
    draft.view(bytes_of(kSquare));
    const auto with = [&](const std::string& offset) {
        Draft copy = draft;
        copy.accessor(
            R"("bufferView":0.0,"componentType":5126,"count":3,"type":"VEC3","byteOffset":)" +
            offset);
        return copy;
    };
    CHECK(read_draft(with("12.0")).meshes.at(0).positions[0] == Vec3f(1, 0, 0));
    for (const char* bad : {"-1", "0.5", "\"12\"", "4294967296", "1e99", "null", "[12]"})
        CHECK_THAT(message_of_draft(with(bad)), has("accessors[0].byteOffset"));
}

TEST_CASE("Normals are made unit, and a normal without direction comes from its triangle") {
    Draft draft = Draft().points(kCorner);
    draft.primitive = R"({"attributes":{"POSITION":0,"NORMAL":1}})";
    const float nan = std::numeric_limits<float>::quiet_NaN();
    draft.points({0, 3, 4, 0, 0, 0, nan, 0, 1});
    const Scene scene = read_draft(draft);
    CHECK(near(Vec3(scene.meshes[0].normals[0]), {0, 0.6, 0.8}));  // 3-4-5 triangle
    CHECK(near(Vec3(scene.meshes[0].normals[1]), {0, 0, 1}));      // x × y
    CHECK(near(Vec3(scene.meshes[0].normals[2]), {0, 0, 1}));
    CHECK_THAT(scene.warnings.at(0), has("2 normals"));
}

TEST_CASE("Positions that are not finite are refused") {
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
        CHECK_THAT(message_of_draft(Draft().points({0, 0, 0, 1, 0, 0, 0, bad, 0})), has("finite"));
}

TEST_CASE("A node scales, then turns, then moves, its parent does so afterwards") {
    Draft draft = Draft().points(kCorner);
    const double s = std::sqrt(0.5);
    std::ostringstream nodes;
    // Child: scale (2,3,4), a quarter turn about z (x → y), move by (10,0,0).
    // Parent: the matrix p ↦ (p.x + 1, 2 p.y, p.z), column by column.
    nodes << R"([{"name":"top","children":[1],"matrix":[1,0,0,0, 0,2,0,0, 0,0,1,0, 1,0,0,1]},)"
          << R"({"name":"low","mesh":0,"scale":[2,3,4],"translation":[10,0,0],"rotation":[0,0,)"
          << s << "," << s << "]}]";
    draft.nodes = nodes.str();
    const Scene scene = read_draft(draft);
    REQUIRE(scene.nodes.size() == 2);
    CHECK(scene.nodes[0].name == "top");
    CHECK(scene.nodes[0].parent == -1);
    CHECK(scene.nodes[1].parent == 0);
    REQUIRE(scene.instances.size() == 1);
    CHECK(scene.instances[0].node == 1);
    const Affine& m = scene.instances[0].to_world;
    CHECK(near(m.point({0, 0, 0}), {11, 0, 0}));
    CHECK(near(m.point({1, 0, 0}), {11, 4, 0}, 1e-5));  // (2,0,0) → (0,2,0) → (10,2,0) → (11,4,0)
    CHECK(near(m.point({0, 1, 0}), {8, 0, 0}, 1e-5));  // (0,3,0) → (−3,0,0) → (7,0,0) → (8,0,0)
}

TEST_CASE("Each axis of rotation turns counter-clockwise, for quaternions of any length") {
    const double s = GENERATE(0.1, 0.5, 3.0);
    const auto turned = [&](const std::string& q, const Vec3& p) {
        Draft draft = Draft().points(kCorner);
        draft.nodes = R"([{"mesh":0,"rotation":[)" + q + "]}]";
        return read_draft(draft).instances.at(0).to_world.point(p);
    };
    const std::string c = std::to_string(s);
    CHECK(near(turned(c + ",0,0," + c, {0, 1, 0}), {0, 0, 1}));
    CHECK(near(turned("0," + c + ",0," + c, {0, 0, 1}), {1, 0, 0}));
    CHECK(near(turned("0,0," + c + "," + c, {1, 0, 0}), {0, 1, 0}));
    CHECK(near(turned(c + "," + c + "," + c + "," + c, {1, 0, 0}), {0, 1, 0}));  // x→y→z→x
}

TEST_CASE("A rotation of zero and a node with matrix and rotation are refused") {
    Draft draft = Draft().points(kCorner);
    draft.nodes = R"([{"mesh":0,"rotation":[0,0,0,0]}])";
    CHECK_THAT(message_of_draft(draft), has("nodes[0].rotation"));
    draft.nodes = R"([{"mesh":0,"rotation":[0,0,0,1],"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}])";
    CHECK_THAT(message_of_draft(draft), has("both matrix and rotation"));
    draft.nodes = R"([{"mesh":0,"matrix":[1,0,0,0.5,0,1,0,0,0,0,1,0,0,0,0,1]}])";
    CHECK_THAT(message_of_draft(draft), has("nodes[0].matrix"));
    draft.nodes = R"([{"mesh":0,"translation":[1,"2",3]}])";
    CHECK_THAT(message_of_draft(draft), has("nodes[0].translation[1]"));
    draft.nodes = R"([{"mesh":0,"scale":[1e300,1,1]}])";
    CHECK_THAT(message_of_draft(draft), has("finite"));
}

TEST_CASE("A negative scale stays in the placement") {
    Draft draft = Draft().points(kCorner);
    draft.nodes = R"([{"mesh":0,"scale":[-1,1,1]}])";
    const Scene scene = read_draft(draft);
    CHECK(scene.instances.at(0).to_world.determinant() == -1);
    CHECK(scene.meshes[0].triangles[0] == std::array<std::uint32_t, 3>{0, 1, 2});
    CHECK(malus::bounds(scene).lower == Vec3(-1, 0, 0));
}

TEST_CASE("Nodes that name one mesh share it") {
    Draft draft = Draft().points(kCorner);
    draft.nodes = R"([{"mesh":0},{"mesh":0,"translation":[5,0,0]},{"mesh":0}])";
    draft.roots = "2,0,1";
    const Scene scene = read_draft(draft);
    CHECK(scene.meshes.size() == 1);
    REQUIRE(scene.instances.size() == 3);
    CHECK(scene.instances[0].node == 2);
    CHECK(scene.instances[2].to_world.t == Vec3(5, 0, 0));
    CHECK(malus::triangle_count(scene) == 3);
}

TEST_CASE("Each primitive is a mesh of its own with its own surface") {
    Draft draft = Draft().points(kCorner);
    draft.primitive = R"({"attributes":{"POSITION":0},"material":1},{"attributes":{"POSITION":0}})";
    draft.more = R"(,"materials":[{"name":"paint"},{}])";
    const Scene scene = read_draft(draft);
    CHECK(scene.surfaces == std::vector<std::string>{"paint", ""});
    REQUIRE(scene.meshes.size() == 2);
    CHECK(scene.meshes[0].surface == 1);
    CHECK(scene.meshes[1].surface == -1);
    CHECK(scene.meshes[1].name == "m");
}

TEST_CASE("Only the nodes of the default scene are placed, or of the first, or all roots") {
    Draft draft = Draft().points(kCorner);
    draft.nodes = R"([{"mesh":0,"translation":[1,0,0]},{"mesh":0,"translation":[2,0,0]}])";
    CHECK(read_draft(draft).instances.size() == 1);
    std::string text = draft.embedded();
    const std::string one = R"("scenes":[{"nodes":[0]}])";
    const std::size_t at = text.find(one);
    REQUIRE(at != std::string::npos);
    const auto with = [&](const std::string& scenes) {
        std::string copy = text;
        return copy.replace(at, one.size(), scenes);
    };
    const Scene second = read_text(with(R"("scene":1,"scenes":[{"nodes":[0]},{"nodes":[1]}])"));
    REQUIRE(second.instances.size() == 1);
    CHECK(second.instances[0].node == 1);
    CHECK(second.nodes.size() == 2);
    CHECK(read_text(with(R"("scenes":[])")).instances.size() == 2);
    CHECK_THAT(message_of_text(with(R"("scene":-1,"scenes":[{"nodes":[0]}])")), has("scene: -1"));
}

TEST_CASE("A hierarchy that is not a tree is refused") {
    Draft draft = Draft().points(kCorner);
    draft.nodes = R"([{"mesh":0,"children":[0]}])";
    CHECK_THAT(message_of_draft(draft), has("cycle"));
    draft.nodes = R"([{"mesh":0},{"children":[2]},{"children":[1]}])";
    CHECK_THAT(message_of_draft(draft), has("cycle"));
    draft.nodes = R"([{"children":[2]},{"children":[2]},{"mesh":0}])";
    CHECK_THAT(message_of_draft(draft), has("nodes[2]: is a child twice"));
    draft.nodes = R"([{"mesh":0,"children":[7]}])";
    CHECK_THAT(message_of_draft(draft), has("nodes[0].children[0]: index 7"));
}

TEST_CASE("A chain of a hundred thousand nodes is walked without recursion") {
    Draft draft = Draft().points(kCorner);
    draft.nodes = "[";
    for (int i = 1; i < 100'000; ++i)
        draft.nodes += R"({"translation":[0,0,1],"children":[)" + std::to_string(i) + "]},";
    draft.nodes += R"({"mesh":0}])";
    CHECK(read_draft(draft).instances.at(0).to_world.t == Vec3(0, 0, 99'999));
}

TEST_CASE("A camera looks along its node's −z with +y up, whatever the node's scale") {
    Draft draft = Draft().points(kCorner);
    draft.roots = "0,1";
    draft.more = R"(,"cameras":[{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1}}])";
    const auto camera = [&](const std::string& placement) {
        draft.nodes = R"([{"mesh":0},{"name":"eye","camera":0)" + placement + "}]";
        return read_draft(draft).cameras.at(0);
    };
    const Camera plain = camera(R"(,"translation":[1,2,3])");
    CHECK(plain.name == "eye");
    CHECK(plain.projection == malus::Projection::kPerspective);
    CHECK(plain.yfov == 0.5);
    CHECK(plain.position == Vec3(1, 2, 3));
    CHECK(near(plain.right, {1, 0, 0}));
    CHECK(near(plain.up, {0, 1, 0}));
    CHECK(near(plain.forward, {0, 0, -1}));
    // A quarter turn about x brings −z to +y and +y to +z: the camera looks up, its top to south.
    const Camera turned = camera(R"(,"rotation":[0.5,0,0,0.5],"scale":[2,3,7])");
    CHECK(near(turned.forward, {0, 1, 0}));
    CHECK(near(turned.up, {0, 0, 1}));
    CHECK(near(turned.right, {1, 0, 0}));
    const Camera mirrored = camera(R"(,"scale":[-2,1,1])");
    CHECK(near(malus::cross(mirrored.right, mirrored.up), -mirrored.forward));
    CHECK(near(mirrored.forward, {0, 0, -1}));
    CHECK(near(mirrored.up, {0, 1, 0}));
    draft.nodes = R"([{"mesh":0},{"camera":0,"scale":[1,1,0]}])";
    CHECK_THAT(message_of_draft(draft), has("nodes[1]: camera"));
}

TEST_CASE("An orthographic camera keeps xmag and ymag, and its own name") {
    Draft draft = Draft().points(kCorner);
    draft.nodes = R"([{"mesh":0},{"name":"node","camera":0}])";
    draft.roots = "0,1";
    draft.more = R"(,"cameras":[{"name":"ortho","type":"orthographic",)"
                 R"("orthographic":{"xmag":4,"ymag":3,"znear":0,"zfar":10}}])";
    const Camera camera = read_draft(draft).cameras.at(0);
    CHECK(camera.name == "ortho");
    CHECK(camera.projection == malus::Projection::kOrthographic);
    CHECK(camera.xmag == 4);
    CHECK(camera.ymag == 3);
}

TEST_CASE("Camera parameters out of range are refused by name") {
    const auto with = [](const std::string& camera) {
        Draft draft = Draft().points(kCorner);
        draft.more = R"(,"cameras":[)" + camera + "]";
        return message_of_draft(draft);
    };
    const auto lens = [&](const std::string& values) {
        return with(R"({"type":"perspective","perspective":{)" + values + "}}");
    };
    CHECK_THAT(lens(R"("yfov":0,"znear":1)"), has("cameras[0].perspective.yfov"));
    CHECK_THAT(lens(R"("yfov":3.2,"znear":1)"), has("cameras[0].perspective.yfov"));
    CHECK_THAT(lens(R"("yfov":1,"znear":0)"), has("cameras[0].perspective.znear"));
    CHECK_THAT(lens(R"("yfov":1,"znear":1,"zfar":1)"), has("cameras[0].perspective.zfar"));
    CHECK_THAT(lens(R"("znear":1)"), has("cameras[0].perspective.yfov: is missing"));
    CHECK_THAT(with(R"({"type":"perspective"})"), has("no block 'perspective'"));
    CHECK_THAT(with(R"({"type":"fisheye"})"), has("fisheye"));
    CHECK_THAT(
        with(R"({"type":"orthographic","orthographic":{"xmag":0,"ymag":1,"znear":0,"zfar":1}})"),
        has("cameras[0].orthographic.xmag"));
}

TEST_CASE("A buffer's uri is percent-decoded, and a plus sign stays one") {
    const TempFolder folder;
    const Draft draft = Draft().points(kCorner);
    folder.write("my data+1.bin", draft.data + "and more than byteLength");
    const auto scene = folder.write("scene.gltf", draft.json(R"(,"uri":"my%20data+1.bin")"));
    CHECK(malus::triangle_count(read_gltf(scene)) == 1);
    const auto bad = folder.write("bad.gltf", draft.json(R"(,"uri":"my%2ydata.bin")"));
    CHECK_THAT(message_of(bad), has("two hex digits"));
    folder.write("short.bin", "abc");
    const auto cut = folder.write("cut.gltf", draft.json(R"(,"uri":"short.bin")"));
    CHECK_THAT(message_of(cut), has("buffers[0].byteLength: 36 exceeds"));
}

TEST_CASE("A data URI may have any media type or none, with base64 or without") {
    const Draft draft = Draft().points(kCorner);
    const auto with = [&](const std::string& uri) {
        return message_of_text(draft.json(",\"uri\":\"" + uri + "\""));
    };
    CHECK(with("data:;base64," + base64(draft.data)) == "no error");
    CHECK(with("DATA:model/x;q=1;base64," + base64(draft.data)) == "no error");
    std::string percent = "data:,";
    for (const char byte : draft.data) {
        char text[4];
        std::snprintf(text, sizeof text, "%%%02x", static_cast<unsigned char>(byte));
        percent += text;
    }
    CHECK(with(percent) == "no error");
    CHECK_THAT(with("data:;base64"), has("comma"));
    CHECK_THAT(with("data:;base64,AA!A"), has("not base64"));
    CHECK_THAT(with("data:;base64,AAAA"), has("exceeds the data's length of 3 bytes"));
}

TEST_CASE("No buffer comes from outside the scene's folder") {
    const TempFolder folder;
    const Draft draft = Draft().points(kCorner);
    folder.write("secret.bin", draft.data);
    fs::create_directories(folder.path() / "in");
    fs::create_symlink("../secret.bin", folder.path() / "in" / "link.bin");
    fs::create_directory_symlink("..", folder.path() / "in" / "up");
    const auto with = [&](const std::string& uri) {
        return message_of(folder.write("in/scene.gltf", draft.json(",\"uri\":\"" + uri + "\"")));
    };
    CHECK_THAT(with("link.bin"), has("outside the scene's folder"));
    CHECK_THAT(with("up/secret.bin"), has("outside the scene's folder"));
    CHECK_THAT(with("../secret.bin"), has("'..', which is not allowed"));
    CHECK_THAT(with("%2e%2e/secret.bin"), has("'..', which is not allowed"));
    CHECK_THAT(with((folder.path() / "secret.bin").string()), has("absolute"));
    CHECK_THAT(with("%2Fetc/passwd"), has("absolute"));
    CHECK_THAT(with("file:///etc/passwd"), has("scheme"));
    CHECK_THAT(with("..\\\\secret.bin"), has("backslash"));
    CHECK_THAT(with("a%00b"), has("zero byte"));
    CHECK_THAT(with("."), has("not a regular file"));
    CHECK_THAT(with("absent.bin"), has("not found"));
}

TEST_CASE("A pipe is refused as scene and as buffer, without waiting for a writer") {
    const TempFolder folder;
    const Draft draft = Draft().points(kCorner);
    REQUIRE(::mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
    CHECK_THAT(message_of(folder.path() / "pipe"), has("not a regular file"));
    CHECK_THAT(message_of(folder.write("scene.gltf", draft.json(R"(,"uri":"pipe")"))),
               has("not a regular file"));
    CHECK_THAT(message_of(folder.path()), has("not a regular file"));
    CHECK_THAT(message_of(folder.path() / "absent.gltf"), has("absent.gltf: file"));
}

TEST_CASE("An error is one line that starts with the file, even when the file's names are not") {
    const TempFolder folder;
    Draft draft = Draft().points(kCorner);
    draft.more = R"(,"extensionsRequired":["A\n\u001b[31mB)" + std::string(5000, 'x') + "\"]";
    const auto path = folder.write("scene.gltf", draft.embedded());
    const std::string text = message_of(path);
    CHECK(text.rfind(path.string() + ": extensionsRequired: ", 0) == 0);
    CHECK(text.size() < path.string().size() + 400);
    for (const char c : text) CHECK(static_cast<unsigned char>(c) >= 0x20);
}

TEST_CASE("Versions other than 2 are refused by name") {
    CHECK_THAT(message_of_text(R"({"asset":{"version":"1.0"}})"), has("asset.version: 1.0"));
    CHECK_THAT(message_of_text(R"({"asset":{"version":2.0}})"), has("asset.version"));
    CHECK_THAT(message_of_text(R"({"asset":{"version":"2.0","minVersion":"2.1"}})"),
               has("asset.minVersion"));
    CHECK_THAT(message_of_text("{}"), has("asset"));
    CHECK_THAT(message_of_text("glTF" + bytes_of<std::uint32_t>({1, 20, 0, 0})), has("version 1"));
}

TEST_CASE("Extensions that leave geometry alone may be required, others not") {
    Draft draft = Draft().points(kCorner);
    draft.more = R"(,"extensionsRequired":["KHR_materials_ior","KHR_texture_basisu"])";
    CHECK(message_of_draft(draft) == "no error");
    draft.more = R"(,"extensionsRequired":["KHR_draco_mesh_compression"])";
    CHECK_THAT(message_of_draft(draft), has("KHR_draco_mesh_compression"));
}

TEST_CASE("Lists of the wrong kind are refused by name") {
    for (const char* key : {"extensionsRequired", "cameras", "materials", "skins"}) {
        Draft draft = Draft().points(kCorner);
        draft.more = ",\"" + std::string(key) + "\":{}";
        CHECK_THAT(message_of_draft(draft), has(std::string(key) + ": must be an array"));
    }
}

TEST_CASE("Images, animations and extras are not looked at") {
    Draft draft = Draft().points(kCorner);
    draft.more = R"(,"images":[{"uri":"/dev/zero"},{"bufferView":99}],"textures":[7])"
                 R"(,"animations":[0],"extras":[[{"a":null}]],"extensions":{"X":1})";
    const Scene scene = read_draft(draft);
    CHECK(malus::triangle_count(scene) == 1);
    CHECK(scene.warnings.size() == 2);
}

TEST_CASE("JSON nested a hundred thousand levels deep is refused before it is parsed") {
    const std::string deep(100'000, '[');
    CHECK_THAT(message_of_text(deep), has("nested deeper"));
    CHECK_THAT(message_of_text(R"({"asset":{"version":"2.0"},"extras":)" + deep), has("nested"));
    // Brackets in a string are no nesting.
    Draft draft = Draft().points(kCorner);
    draft.more = R"(,"extras":"\")" + deep + "\"";
    CHECK(message_of_draft(draft) == "no error");
}

TEST_CASE("Counts beyond the memory limit are refused, not tried") {
    Draft draft;
    draft.data = "four";
    draft.accessor(R"("componentType":5126,"count":2000000000,"type":"VEC3")");
    CHECK_THAT(message_of_draft(draft), has("too large for the memory limit"));
    CHECK_THAT(message_of_text("{\"a\":[" + std::string(9'000'000, ',')), has("memory limit"));
}

namespace {

std::string small_glb() {
    Draft draft = Draft().points(kSquare);
    draft.points({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
    draft.typed(bytes_of<std::uint16_t>({0, 1, 2, 2, 1, 3}), 5123, 6, "SCALAR");
    draft.primitive = R"({"attributes":{"POSITION":0,"NORMAL":1},"indices":2,"material":0})";
    draft.nodes =
        R"([{"children":[1],"rotation":[0,0,0,1]},{"mesh":0,"camera":0,"scale":[1,2,3]}])";
    draft.more = R"(,"materials":[{"name":"p"}],"cameras":[{"type":"perspective",)"
                 R"("perspective":{"yfov":1,"znear":1}}])";
    return glb(draft.json(""), draft.data);
}

}  // namespace

TEST_CASE("A GLB cut at any byte is refused with an Error") {
    const TempFolder folder;
    const std::string whole = small_glb();
    REQUIRE(malus::triangle_count(read_gltf(folder.write("whole.glb", whole))) == 2);
    for (std::size_t size = 0; size < whole.size(); ++size)
        REQUIRE_THROWS_AS(read_gltf(folder.write("cut.glb", whole.substr(0, size))), Error);
}

TEST_CASE("A GLB with random bytes changed gives a finite scene or an Error, nothing else") {
    const TempFolder folder;
    const std::string whole = small_glb();
    std::mt19937 random(20240501);
    int accepted = 0;
    for (int round = 0; round < 4000; ++round) {
        std::string changed = whole;
        for (unsigned k = 1 + random() % 4; k-- > 0;)
            changed[random() % changed.size()] = static_cast<char>(random() % 256);
        try {
            const Scene scene = read_gltf(folder.write("changed.glb", changed));
            ++accepted;
            const Box box = malus::bounds(scene);
            REQUIRE(malus::is_finite(box.lower));
            REQUIRE(malus::is_finite(box.upper));
            for (const auto& mesh : scene.meshes)
                for (const Vec3f& n : mesh.normals)
                    REQUIRE(std::abs(malus::length(Vec3(n)) - 1) < 1e-6);
        } catch (const Error&) {
        }
    }
    CHECK(accepted > 100);  // or the test would say nothing about what is accepted
}

namespace {

// Fields of one line of CSV; quotes may enclose commas.
std::vector<std::string> csv_fields(const std::string& line) {
    std::vector<std::string> fields(1);
    bool quoted = false;
    for (const char c : line) {
        if (c == '"') {
            quoted = !quoted;
        } else if (c == ',' && !quoted) {
            fields.emplace_back();
        } else if (c != '\r') {
            fields.back() += c;
        }
    }
    return fields;
}

std::string lower_case(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

// The patterns in the file are literal words with | between and \. for a full stop.
bool matches(std::string text, const std::string& pattern) {
    text = lower_case(text);
    std::string words = lower_case(pattern);
    std::erase(words, '\\');
    std::istringstream stream(words);
    for (std::string word; std::getline(stream, word, '|');)
        if (text.find(word) != std::string::npos) return true;
    return words.empty();
}

void check_row(const fs::path& folder, const std::vector<std::string>& row) {
    const std::string file = (folder / row[0]).string();
    INFO(row[0]);
    const bool ok = row[1].rfind("OK:", 0) == 0;
    try {
        const Scene scene = read_gltf(file);
        CHECK((ok || row[1] == "EITHER"));
        if (!ok) return;
        CHECK(malus::triangle_count(scene) == std::stoul(row[1].substr(3)));
        CHECK(area_of(scene) == Approx(std::stod(row[3])).epsilon(1e-4));
        const Box box = malus::bounds(scene);
        const double size = malus::length(box.upper - box.lower);
        std::istringstream numbers(row[4]);
        Vec3 lower, upper;
        numbers >> lower.x >> lower.y >> lower.z >> upper.x >> upper.y >> upper.z;
        CHECK(near(box.lower, lower, 1e-5 * size));
        CHECK(near(box.upper, upper, 1e-5 * size));
    } catch (const Error& error) {
        INFO(error.what());
        CHECK_FALSE(ok);
        const std::string message = error.what();
        REQUIRE(message.rfind(file + ": ", 0) == 0);
        CHECK(matches(message.substr(file.size()), row[2]));
        CHECK(message.find('\n') == std::string::npos);
    }
}

}  // namespace

TEST_CASE("Every file of data/gltf does what expected.csv says") {
    const fs::path folder = fs::path(MALUS_SHARED_DATA) / "gltf";
    std::ifstream table(folder / "expected.csv");
    if (std::string(MALUS_SHARED_DATA).empty() || !table) {
        WARN("the shared data folder is absent: expected.csv is not checked");
        return;
    }
    std::string line;
    std::getline(table, line);  // header
    int rows = 0;
    for (; std::getline(table, line); ++rows) {
        const auto row = csv_fields(line);
        REQUIRE(row.size() >= 5);
        check_row(folder, row);
    }
    CHECK(rows == 104);
}
