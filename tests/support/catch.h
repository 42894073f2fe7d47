// catch.h — the test framework, Catch2 version 2 or 3, under one name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif

/// Equal within `margin`, and no more: Approx by itself also allows 1.2e-5 of the value.
inline Approx near(double value, double margin) {
    return Approx(value).epsilon(0).margin(margin);
}
