// program.cpp — the program's exit code and what it wrote.
// SPDX-License-Identifier: Apache-2.0
#include "support/program.h"

#include <sys/wait.h>

#include <cstdlib>

#include "malus/io/file.h"
#include "support/catch.h"
#include "support/fixtures.h"

namespace malus {

std::string quoted(const std::string& word) {
    return "'" + word + "'";
}

Outcome run(const std::string& arguments) {
    const TempFolder folder;
    const std::string out = (folder / "out").string(), err = (folder / "err").string();
    const int status = std::system((quoted(MALUS_PROGRAM) + " " + arguments + " >" + quoted(out) +
                                    " 2>" + quoted(err) + " </dev/null")
                                       .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), read_text(out),
            read_text(err)};
}

std::string shipped(const std::string& file) {
    return quoted(MALUS_SOURCE_DIR "/" + file);
}

std::string small_render(const std::string& out, const std::string& more, const std::string& size) {
    return "render " + shipped("scenes/panel.gltf") + " --sky " + shipped("skies/rayleigh_60.exr") +
           " --materials " + shipped("materials/paints.json") + " --assign '*=green_paint' " +
           size + " -o " + quoted(out) + " " + more;
}

void check_fails(const std::string& arguments, const std::filesystem::path& image,
                 const std::vector<std::string>& words) {
    const Outcome result = run(arguments);
    CAPTURE(arguments, result.err);
    CHECK(result.exit_code == 1);
    CHECK(result.one_line());
    for (const std::string& word : words) CHECK_THAT(result.err, Catch::Contains(word));
    CHECK_FALSE(std::filesystem::exists(image));
}

}  // namespace malus
