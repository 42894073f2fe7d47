// contract.h — checks of our own promises; a failure is a bug in malus, never the user's fault.
//
// EXPECT(c) at a function's start states what it needs, ENSURE(c) at its end what it gives.
// Both are on in debug and sanitizer builds (no NDEBUG) and cost nothing otherwise.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>

#define EXPECT(condition) assert((condition) && "precondition")
#define ENSURE(condition) assert((condition) && "postcondition")
