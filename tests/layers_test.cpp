// layers_test.cpp — who may include whom, and where third-party libraries may appear.
// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>

#include "support/catch.h"

namespace fs = std::filesystem;

namespace {

struct Include {
    std::string file, target;
    bool quoted;
};

// Every #include of the program's own sources; files relative to the checkout.
std::vector<Include> includes() {
    std::vector<Include> found;
    const std::regex line_form(R"re(\s*#\s*include\s*([<"])([^>"]+)[>"].*)re");
    for (const char* folder : {"include", "src"})
        for (const auto& entry :
             fs::recursive_directory_iterator(fs::path(MALUS_SOURCE_DIR) / folder)) {
            if (!entry.is_regular_file()) continue;
            std::ifstream in(entry.path());
            for (std::string line; std::getline(in, line);) {
                std::smatch match;
                if (std::regex_match(line, match, line_form))
                    found.push_back({fs::relative(entry.path(), MALUS_SOURCE_DIR).string(),
                                     match[2], match[1] == "\""});
            }
        }
    return found;
}

// The layer of "include/malus/io/exr.h", "src/io/exr.cpp", "malus/io/exr.h" or "io/exr.h".
std::string layer(std::string path) {
    for (const std::string prefix : {"include/malus/", "src/", "malus/"})
        if (path.starts_with(prefix)) path = path.substr(prefix.size());
    return path.substr(0, path.find('/'));
}

}  // namespace

TEST_CASE("Layers: each includes only those before it") {
    const std::map<std::string, std::set<std::string>> allowed{
        {"core", {"core"}},
        {"optics", {"core", "optics"}},
        {"scene", {"core", "optics", "scene"}},
        {"render", {"core", "optics", "scene", "render"}},
        {"io", {"core", "optics", "scene", "io"}},
        {"analysis", {"core", "optics", "io", "analysis"}},
        {"preview", {"core", "optics", "scene", "io", "analysis", "preview"}}};
    std::size_t checked = 0;
    for (const Include& i : includes()) {
        const auto rule = allowed.find(layer(i.file));
        if (!i.quoted || rule == allowed.end() || i.target.find('/') == std::string::npos) continue;
        ++checked;
        // What io writes of a render: its film, its sums and its counts.
        if (layer(i.file) == "io" &&
            (i.target == "malus/render/film.h" || i.target == "malus/render/exposure.h" ||
             i.target == "malus/render/render.h"))
            continue;
        INFO(i.file << " includes " << i.target);
        CHECK(rule->second.count(layer(i.target)) == 1);
    }
    CHECK(checked > 50);
}

TEST_CASE("Third parties: one dependency, one place, none in public headers") {
    const std::map<std::string, std::string> place{{"embree3/", "src/render/accel.cpp"},
                                                   {"embree4/", "src/render/accel.cpp"},
                                                   {"tbb/", "src/render/render.cpp"},
                                                   {"tiny_gltf.h", "src/io/gltf.cpp"},
                                                   {"Imf", "src/io/exr.cpp"},
                                                   {"CLI/", "src/cli/"},
                                                   {"OpenImageIO/", "src/preview/"},
                                                   {"xsimd/", "src/render/lanes.h"},
                                                   {"Eigen/", "src/scene/radiative_transfer.cpp"},
                                                   {"nlohmann/", "src/io/"}};
    for (const Include& i : includes())
        for (const auto& [library, home] : place) {
            if (!i.target.starts_with(library)) continue;
            INFO(i.file << " includes " << i.target);
            const bool program = library == "CLI/" &&
                                 (i.file == "src/main.cpp" || i.file.starts_with("src/preview/"));
            // JSON is also what commands print.
            const bool printed = library == "nlohmann/" && i.file.starts_with("src/cli/");
            CHECK((program || printed || i.file.starts_with(home)));
        }
}

TEST_CASE("Tests: no name holds a character that hides tests from ctest") {
    // CMake takes ';' for a list's separator and '[' for the start of a group.
    const std::regex declaration(R"re(TEST_CASE\(\s*"([^"]*)")re");
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(MALUS_SOURCE_DIR) / "tests")) {
        if (entry.path().extension() != ".cpp") continue;
        std::ifstream in(entry.path());
        const std::string text(std::istreambuf_iterator<char>(in), {});
        for (std::sregex_iterator i(text.begin(), text.end(), declaration), end; i != end; ++i) {
            const std::string name = (*i)[1];
            CAPTURE(name);
            CHECK(name.find_first_of(";[]\\") == std::string::npos);
        }
    }
}
