/// Counts the allocations of this program and of the library.
#pragma once

#include <cstddef>

/// The number of allocations of all threads until now. Only glibc lets a program count those of libraries.
std::size_t allocations();
