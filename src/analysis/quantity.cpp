// quantity.cpp — channels of an image as quantities.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/quantity.h"

#include <algorithm>
#include <cmath>

#include "malus/core/error.h"
#include "malus/io/spectral_image.h"
#include "malus/optics/stokes.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

bool has(const Image& image, const std::string& quantity, double nm) {
    return std::any_of(image.channels.begin(), image.channels.end(), [&](const auto& channel) {
        const auto parsed = parse_spectral_channel(channel.first);
        return parsed && parsed->quantity == quantity &&
               std::abs(parsed->wavelength_nm - nm) < kSameWavelength_nm;
    });
}

// of(S) of each pixel.
template <class Of>
std::vector<float> from_stokes(const Image& image, double nm, Of of) {
    const std::vector<float>&s0 = spectral_data(image, "S0", nm),
          &s1 = spectral_data(image, "S1", nm), &s2 = spectral_data(image, "S2", nm),
          &s3 = spectral_data(image, "S3", nm);
    std::vector<float> result(s0.size());
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] = static_cast<float>(of(Stokes<double>{s0[i], s1[i], s2[i], s3[i]}));
    return result;
}

double ratio(double a, double b) {
    return b == 0 ? 0 : a / b;
}

// Of Si/S0.
std::vector<float> ratio_error(const Image& image, const std::string& component, double nm,
                               const std::vector<float>& ratios) {
    const std::string covariance = "Cov_S0" + component;
    for (const std::string& needed : {std::string("StdErr_S0"), "StdErr_" + component, covariance})
        if (!has(image, needed, nm)) return {};
    const std::vector<float>&s0 = spectral_data(image, "S0", nm),
          &e0 = spectral_data(image, "StdErr_S0", nm),
          &ei = spectral_data(image, "StdErr_" + component, nm),
          &c0i = spectral_data(image, covariance, nm);
    std::vector<float> error(ratios.size());
    for (std::size_t p = 0; p < error.size(); ++p) {
        const double q = ratios[p], e = e0[p],
                     variance = sqr(double{ei[p]}) - 2 * q * c0i[p] + sqr(q * e);
        error[p] = static_cast<float>(ratio(std::sqrt(std::max(variance, 0.0)), s0[p]));
    }
    return error;
}

}  // namespace

Quantity read_quantity(const Image& image, const std::string& name, double nm) {
    Quantity q{name, nm, {}, {}, 0};
    if (name.ends_with("/S0") && name.size() == 5) {
        const std::string component = name.substr(0, 2);
        const std::vector<float>&s0 = spectral_data(image, "S0", nm),
              &si = spectral_data(image, component, nm);
        q.value.resize(s0.size());
        for (std::size_t i = 0; i < s0.size(); ++i)
            q.value[i] = static_cast<float>(ratio(si[i], s0[i]));
        if (component != "S3") q.error = ratio_error(image, component, nm, q.value);
        return q;
    }
    if (name == "AoLP") q.period = 180;
    if (name == "DoLP" && !has(image, name, nm))
        q.value = from_stokes(image, nm, [](const Stokes<double>& S) { return dolp(S); });
    else if (name == "AoLP" && !has(image, name, nm))
        q.value =
            from_stokes(image, nm, [](const Stokes<double>& S) { return to_degrees(aolp(S)); });
    else
        q.value = spectral_data(image, name, nm);
    if (has(image, "StdErr_" + name, nm)) q.error = spectral_data(image, "StdErr_" + name, nm);
    return q;
}

double difference(double a, double b, double period) {
    const double d = a - b;
    return period > 0 ? d - period * std::floor(d / period + 0.5) : d;
}

std::vector<double> wavelengths_of(const Image& image, const std::vector<double>& asked_nm) {
    return wavelengths_of(stokes_wavelengths(image), asked_nm);
}

std::vector<double> wavelengths_of(const std::vector<double>& available,
                                   const std::vector<double>& asked_nm) {
    if (available.empty())
        throw Error(
            "no Stokes channels (S0.440,000000nm and so on); name an image or sky map that malus "
            "wrote");
    if (asked_nm.empty()) return available;
    std::vector<double> chosen;
    for (double nm : asked_nm) {
        const auto found = find_wavelength(available, nm);
        if (!found)
            throw Error("no " + to_text(nm) + " nm; choose --wavelengths among " +
                        to_text(available));
        if (find_wavelength(chosen, nm))
            throw Error("--wavelengths: " + to_text(nm) + " nm stands twice; keep one");
        chosen.push_back(available[*found]);
    }
    return chosen;
}

void debias(Quantity& dolp, const Film& film) {
    const auto w = find_wavelength(film.wavelengths_nm, dolp.wavelength_nm);
    for (std::size_t i = 0; i < dolp.value.size(); ++i)
        dolp.value[i] = static_cast<float>(debiased_dolp(film.at(i, w.value())));
}

}  // namespace malus
