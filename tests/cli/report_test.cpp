// report_test.cpp — malus report, and its page as a browser shows it.
// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "malus/io/exr.h"
#include "malus/io/file.h"
#include "malus/io/spectral_image.h"
#include "support/catch.h"
#include "support/fixtures.h"
#include "support/program.h"

using namespace malus;
using Catch::Contains;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

constexpr int kWidth = 40, kHeight = 30;

void render(const fs::path& image, const std::string& more = "") {
    const Outcome result =
        run("render " + shipped("scenes/target_a.glb") + " --sky " +
            shipped("skies/rayleigh_60.exr") + " --materials " + shipped("materials/paints.json") +
            " --wavelengths 440,600 --spp 8 --final --quiet --width 40 --height 30 -o " +
            quoted(image.string()) + more);
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
}

std::string report(const std::string& arguments) {
    const Outcome result = run("report " + arguments);
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    return result.out;
}

// What `script`, run when the page has loaded, leaves in `outcome`, as the page is shown by Chromium
// in a window of this width, without a network; "problems" lists its errors.
json in_browser(const fs::path& page, const std::string& script, const TempFolder& folder,
                int width = 1400) {
    std::string html = read_text(page);
    const auto insert = [&](const std::string& before, const std::string& text) {
        const std::size_t at = html.rfind(before);
        REQUIRE(at != std::string::npos);
        html.insert(at, text);
    };
    insert("<title>", R"(<script>const problems = [];
addEventListener('error', event => problems.push(event.message));
addEventListener('securitypolicyviolation', event => problems.push('fetches ' + event.blockedURI));
const complain = console.error;
console.error = (...what) => { problems.push(what.join(' ')); complain(...what); };</script>)");
    insert("</body>", "<script>const outcome = {};\ntry {" + script + R"(
} catch (problem) { problems.push(String(problem)); }
outcome.problems = problems;
outcome.overflow = document.documentElement.scrollWidth - innerWidth;
const left = document.createElement('pre');
left.textContent = 'OUTCOME ' + JSON.stringify(outcome) + ' END';
document.body.replaceChildren(left);</script>)");
    const fs::path copy = folder / "tested.html", out = folder / "dom.txt",
                   log = folder / "log.txt";
    write_text(copy, html);
    const std::string command =
        "timeout 120 chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage "
        "--user-data-dir='" +
        (folder / "profile").string() +
        "' --host-resolver-rules='MAP * ~NOTFOUND' --virtual-time-budget=10000 --window-size=" +
        std::to_string(width) + ",1000 --dump-dom 'file://" + copy.string() + "' >'" +
        out.string() + "' 2>'" + log.string() + "'";
    const int code = std::system(command.c_str());
    INFO("chromium (tools/setup installs it): " << read_text(log));
    REQUIRE(code == 0);
    const std::string dom = read_text(out);
    const std::size_t from = dom.find("OUTCOME "), to = dom.find(" END", from);
    REQUIRE(from != std::string::npos);
    std::string text = dom.substr(from + 8, to - from - 8);
    for (const auto& [entity, character] : {std::pair("&lt;", "<"), {"&gt;", ">"}, {"&amp;", "&"}})
        for (std::size_t at; (at = text.find(entity)) != std::string::npos;)
            text.replace(at, std::string(entity).size(), character);
    return json::parse(text);
}

// Of the page: where the middle of a pixel lies, and what pointers and buttons do.
const std::string kHands = R"(
const pointer = (element, type, x, y) => element.dispatchEvent(
    new PointerEvent(type, {clientX: x, clientY: y, bubbles: true, pointerId: 1}));
const onPixel = (type, x, y) => {
  const box = document.getElementById('canvas').getBoundingClientRect();
  pointer(document.getElementById('stage'), type, box.left + (x + 0.5) / 40 * box.width,
          box.top + (y + 0.5) / 30 * box.height);
};
const choose = (id, value) => {
  const select = document.getElementById(id);
  select.value = value;
  select.dispatchEvent(new Event('change'));
};
const press = text => [...document.querySelectorAll('button')].find(b => b.textContent === text).click();
const colors = () => Array.from(document.getElementById('canvas').getContext('2d')
                                    .getImageData(0, 0, 40, 30).data);
const line = quantity => document.querySelector(`#readout [data-quantity="${quantity}"]`).textContent;
const counted = () => Number(document.getElementById('counted').dataset.pixels);
)";

// "S0 0.0123 ± 0.0004 W m⁻² …" → 0.0123
float number_in(const std::string& line) {
    return std::strtof(line.c_str() + line.find(' ') + 1, nullptr);
}

}  // namespace

TEST_CASE("Report: the page shows the image's own numbers, by wavelength and region", "[cli]") {
    const TempFolder folder;
    render(folder / "a.exr");
    const std::string said =
        report(quoted((folder / "a.exr").string()) + " -o " + quoted((folder / "a.html").string()));
    CHECK_THAT(said, Contains("needs no network"));
    const Image image = read_exr(folder / "a.exr");
    const json seen = in_browser(folder / "a.html", kHands + R"(
onPixel('pointermove', 7, 11);
outcome.blue = ['S0', 'DoLP', 'S1/S0'].map(line);
const blue = colors();
choose('wavelength', '1');
onPixel('pointermove', 7, 11);
outcome.red = ['S0', 'DoLP', 'S1/S0'].map(line);
outcome.changed = colors().filter((c, i) => c !== blue[i]).length;
outcome.all = counted();
press('DoLP');
outcome.dolp_colors = new Set(colors()).size;
onPixel('pointerdown', 5, 6);
onPixel('pointermove', 12, 9);
onPixel('pointerup', 14, 9);
outcome.region = counted();
outcome.text = document.getElementById('counted').textContent;
press('Clear region and range');
outcome.cleared = counted();
)",
                                 folder);
    CHECK(seen["problems"] == json::array());
    CHECK(seen["overflow"].get<int>() <= 0);
    const std::size_t pixel = 11 * kWidth + 7;
    for (const auto& [name, nm] : {std::pair("blue", 440.0), {"red", 600.0}}) {
        CAPTURE(name);
        CHECK(number_in(seen[name][0]) == spectral_data(image, "S0", nm)[pixel]);
        CHECK(number_in(seen[name][1]) == spectral_data(image, "DoLP", nm)[pixel]);
        CHECK(number_in(seen[name][2]) ==
              spectral_data(image, "S1", nm)[pixel] / spectral_data(image, "S0", nm)[pixel]);
    }
    CHECK(seen["changed"].get<int>() > 100);
    CHECK(seen["dolp_colors"].get<int>() > 10);
    const std::vector<float>& coverage = image.channels.at("A");
    CHECK(seen["all"].get<long>() ==
          std::count_if(coverage.begin(), coverage.end(), [](float a) { return a > 0; }));
    CHECK(seen["region"] == 10 * 4);  // columns 5 to 14, rows 6 to 9
    CHECK_THAT(seen["text"].get<std::string>(), Contains("columns 5 to 14, rows 6 to 9"));
    CHECK(seen["cleared"] == seen["all"]);
}

TEST_CASE("Report: a range drawn in a histogram keeps its pixels bright", "[cli]") {
    const TempFolder folder;
    render(folder / "a.exr");
    report(quoted((folder / "a.exr").string()));
    const Image image = read_exr(folder / "a.exr");
    // The whole scale of DoLP, from one end of the axis to its middle: DoLP up to 0.5 is kept.
    const json seen = in_browser(folder / "a_report.html", kHands + R"(
choose('wavelength', '1');
press('DoLP');
const before = colors();
const plot = document.querySelector('svg[data-quantity="DoLP"]'), box = plot.getBoundingClientRect();
pointer(plot, 'pointerdown', box.left, box.top + 20);
pointer(plot, 'pointerup', box.left + box.width / 2, box.top + 20);
const after = colors();
outcome.same = 0;
for (let i = 0; i < after.length; i += 4)
  outcome.same += after[i] === before[i] && after[i + 1] === before[i + 1] && after[i + 2] === before[i + 2];
)",
                                 folder, 400);
    CHECK(seen["problems"] == json::array());
    CHECK(seen["overflow"].get<int>() <= 0);
    const std::vector<float>& dolp = spectral_data(image, "DoLP", 600);
    // One pixel of the plot is 1/384 of the axis.
    const auto below = [&](float limit) {
        return std::count_if(dolp.begin(), dolp.end(), [&](float p) { return p <= limit; });
    };
    CHECK(seen["same"].get<long>() >= below(0.496f));
    CHECK(seen["same"].get<long>() <= below(0.504f));
    CHECK(below(0.496f) > 100);
    CHECK(below(0.504f) < kWidth * kHeight - 10);
}

TEST_CASE("Report: images stand beside each other, and names cannot break the page", "[cli]") {
    const TempFolder folder;
    render(folder / "a.exr");
    render(folder / "b<!--<script>.exr", " --seed 5");
    report(quoted((folder / "a.exr").string()) + " " +
           quoted((folder / "b<!--<script>.exr").string()) +
           " --wavelengths 600 --title '</script>&' -o " + quoted((folder / "ab.html").string()));
    const json seen = in_browser(folder / "ab.html", kHands + R"(
outcome.title = document.querySelector('h1').textContent;
outcome.names = [...document.getElementById('image').options].map(o => o.textContent);
outcome.wavelengths = document.getElementById('wavelength').options.length;
outcome.alone = document.querySelectorAll('svg[data-quantity="S0"] path').length;
choose('other', '1');
outcome.beside = document.querySelectorAll('svg[data-quantity="S0"] path').length;
)",
                                 folder);
    CHECK(seen["problems"] == json::array());
    CHECK(seen["title"] == "</script>&");
    CHECK(seen["names"] == json{"a", "b<!--<script>"});
    CHECK(seen["wavelengths"] == 1);
    CHECK(seen["alone"] == 1);
    CHECK(seen["beside"] == 2);
}

TEST_CASE("Report: what cannot be shown is refused in one line", "[cli]") {
    const TempFolder folder;
    render(folder / "a.exr");
    const std::string image = quoted((folder / "a.exr").string());
    const auto refused = [&](const std::string& arguments, const std::string& words) {
        const Outcome result = run("report " + arguments);
        CAPTURE(arguments, result.err);
        CHECK(result.exit_code == 1);
        CHECK(result.one_line());
        CHECK_THAT(result.err, Contains(words));
    };
    refused(image + " --wavelengths 550", "no 550 nm; choose --wavelengths among 440, 600");
    refused(quoted((folder / "none.exr").string()), "none.exr");
    refused(image + " -o " + image, "would replace");
    refused(image + " --intro " + quoted((folder / "none.html").string()), "none.html");
    CHECK_FALSE(fs::exists(folder / "a_report.html"));
    CHECK(run("report").exit_code == 2);
}
