// material_file.cpp — paints from JSON, each key checked.
// SPDX-License-Identifier: Apache-2.0
#include "malus/io/material_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "malus/core/error.h"
#include "malus/io/file.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

using Json = nlohmann::ordered_json;

// Far beyond any surface, and what floats still resolve: outside, sums would overflow or cancel in
// silence. Angles are in the unit of the file.
constexpr double kLeastIndex = 0.05, kMostIndex = 1e3;
constexpr double kLeastSlope = 1e-6, kMostSlope = 100;
constexpr double kLeastAngle = 1e-6, kMostAngle = 1e6;
constexpr double kMostReflected = 1e4;

// A JSON object and where it stands, so that each message can say it.
class Section {
  public:
    Section(const Json& json, std::string place) : json_(json), place_(std::move(place)) {
        if (!json.is_object())
            throw Error(place_ + ": expected an object { … }, found " + json.type_name() +
                        "; see materials/README.md");
    }

    const std::string& place() const { return place_; }
    bool has(const char* key) const { return json_.contains(key); }

    void allow_only(const std::vector<std::string>& known) const {
        for (const auto& [key, value] : json_.items())
            if (std::find(known.begin(), known.end(), key) == known.end())
                throw Error(place_ + ": unknown key '" + one_line(key) + "'" + suggest(key, known));
    }

    const Json& at(const char* key) const {
        if (!has(key)) throw Error(place_ + ": missing key '" + key + "'; add it");
        return json_[key];
    }

    double number(const char* key) const {
        const Json& value = at(key);
        if (!value.is_number())
            throw Error(place_ + ": '" + key + "' must be a number, not " + value.type_name());
        const double x = value.get<double>();
        if (!std::isfinite(x)) throw Error(place_ + ": '" + key + "' must be finite");
        return x;
    }

    double number_above(const char* key, double limit) const {
        const double x = number(key);
        if (!(x > limit))
            throw Error(place_ + ": '" + key + "' is " + to_text(x) + "; it must be > " +
                        to_text(limit));
        return x;
    }

    double number_within(const char* key, double least, double most) const {
        const double x = number(key);
        if (!(x >= least && x <= most))
            throw Error(place_ + ": '" + key + "' is " + to_text(x) + "; it must be within " +
                        to_text(least) + " to " + to_text(most));
        return x;
    }

    // One of a few words; the first is meant where the key is absent.
    std::size_t choice(const char* key, const std::vector<std::string>& words) const {
        if (!has(key)) return 0;
        const Json& value = json_[key];
        const std::string word = value.is_string() ? value.get<std::string>() : value.dump();
        const auto found = std::find(words.begin(), words.end(), word);
        if (found == words.end())
            throw Error(place_ + ": '" + key + "' is '" + one_line(word) + "'" +
                        suggest(word, words));
        return static_cast<std::size_t>(found - words.begin());
    }

    std::string text(const char* key) const {
        const Json& value = at(key);
        if (!value.is_string())
            throw Error(place_ + ": '" + key + "' must be a text, not " + value.type_name());
        return value.get<std::string>();
    }

  private:
    const Json& json_;
    std::string place_;
};

void read_shadowing(const Section& row, PriestGermer<double>& p) {
    p.tau = 1;
    p.inv_omega = 0;
    if (!row.has("shadowing")) return;
    const Section shadowing(row.at("shadowing"), row.place() + ": shadowing");
    shadowing.allow_only({"tau", "Omega", "unit"});
    shadowing.at("unit");
    const bool degrees = shadowing.choice("unit", {"rad", "deg"}) == 1;
    const double unit = degrees ? to_radians(1) : 1;
    p.tau = unit * shadowing.number_within("tau", kLeastAngle, kMostAngle);
    p.inv_omega = 1 / (unit * shadowing.number_within("Omega", kLeastAngle, kMostAngle));
}

// Volume light falls from ρd + ρv (both directions along the normal) to ±∞·ρv at grazing, so it
// can be negative exactly where one of these is.
bool can_be_negative(const PriestGermer<double>& p) {
    return p.rho_v < 0 || p.rho_d + p.rho_v < 0;
}

MaterialRow read_row(const Json& json, const std::string& place) {
    const Section row(json, place);
    row.allow_only(
        {"wavelength_nm", "n", "k", "B", "sigma", "shadowing", "rho_d", "rho_v", "notes"});
    MaterialRow out{row.number_above("wavelength_nm", 0), {}};
    out.p.n = row.number_above("n", 0);
    out.p.k = row.number_within("k", 0, kMostIndex);
    if (out.p.n > kMostIndex || std::hypot(out.p.n, out.p.k) < kLeastIndex)
        throw Error(place + ": 'n' is " + to_text(out.p.n) + "; |n + ik| must be within " +
                    to_text(kLeastIndex) + " to " + to_text(kMostIndex));
    out.p.B = row.number_within("B", 0, kMostReflected);
    out.p.sigma = row.number_within("sigma", kLeastSlope, kMostSlope);
    read_shadowing(row, out.p);
    out.p.rho_d = row.number_within("rho_d", -kMostReflected, kMostReflected);
    out.p.rho_v = row.number_within("rho_v", -kMostReflected, kMostReflected);
    return out;
}

void sort_rows(Material& material) {
    auto& rows = material.rows;
    std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) {
        return a.wavelength_nm < b.wavelength_nm;
    });
    for (std::size_t i = 1; i < rows.size(); ++i)
        if (rows[i].wavelength_nm - rows[i - 1].wavelength_nm < kSameWavelength_nm)
            throw Error(material.place + ": two rows for 'wavelength_nm' " +
                        to_text(rows[i].wavelength_nm) + "; keep one");
}

Material read_material(const std::string& name, const Json& json, const std::string& file,
                       std::vector<std::string>& warnings) {
    const Section section(json, file + ": " + one_line(name));
    section.allow_only({"source", "slopes", "attenuation", "negative_volume", "rows", "notes"});
    Material material;
    material.name = name;
    material.place = section.place();
    if (section.has("source")) material.source = section.text("source");
    if (section.choice("slopes", {"gaussian", "cauchy"}) == 1) material.slopes = Slopes::kCauchy;
    if (section.choice("attenuation", {"none", "torrance-sparrow"}) == 1)
        material.attenuation = Attenuation::kTorranceSparrow;
    const bool reject = section.choice("negative_volume", {"clamp", "reject"}) == 1;
    const Json& rows = section.at("rows");
    if (!rows.is_array() || rows.empty())
        throw Error(section.place() + ": 'rows' must be a list of at least one row");
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::string place = section.place() + ": row " + std::to_string(i + 1);
        material.rows.push_back(read_row(rows[i], place));
        const MaterialRow& row = material.rows.back();
        if (!can_be_negative(row.p)) continue;
        const std::string what = place + " (" + to_text(row.wavelength_nm) +
                                 " nm): rho_d + 2 rho_v/(cos i + cos o) is negative in places";
        if (reject) throw Error(what + "; mend the fit or set \"negative_volume\": \"clamp\"");
        warnings.push_back(what + "; taken as 0 there");
    }
    sort_rows(material);
    return material;
}

// A JSON object keeps the last of two equal keys in silence; in a table of constants that hides a
// slip, so the parser is told to complain. Keys are followed level by level.
Json parse_strictly(const std::string& text) {
    std::vector<std::vector<std::string>> open;
    const auto watch = [&](int, Json::parse_event_t event, Json& parsed) {
        if (event == Json::parse_event_t::object_start) open.emplace_back();
        if (event == Json::parse_event_t::object_end) open.pop_back();
        if (event != Json::parse_event_t::key) return true;
        const auto key = parsed.get<std::string>();
        auto& seen = open.back();
        if (std::find(seen.begin(), seen.end(), key) != seen.end())
            throw Error("key '" + one_line(key) + "' stands twice in one object; keep one");
        seen.push_back(key);
        return true;
    };
    return Json::parse(text, watch);
}

Json parse(const std::string& text, const std::string& file) {
    int depth = 0;
    for (char c : text) {
        depth += (c == '{' || c == '[') ? 1 : (c == '}' || c == ']') ? -1 : 0;
        if (depth > 100) throw Error(file + ": nested deeper than any material; mend the file");
    }
    try {
        return parse_strictly(text);
    } catch (const Json::exception& problem) {
        throw Error(file + ": not valid JSON (" + one_line(problem.what(), 200) +
                    "); mend the file");
    } catch (const Error& problem) {
        throw Error(file + ": " + problem.what());
    }
}

}  // namespace

MaterialFile read_materials(const std::filesystem::path& path) {
    const std::string file = path.string();
    const Json json = parse(read_text(path), file);
    const Section root(json, file);
    root.allow_only({"materials"});
    const Section materials(root.at("materials"), file + ": materials");
    MaterialFile out;
    for (const auto& [name, value] : root.at("materials").items())
        out.materials.push_back(read_material(name, value, file, out.warnings));
    if (out.materials.empty()) throw Error(file + ": holds no material; add one");
    return out;
}

}  // namespace malus
