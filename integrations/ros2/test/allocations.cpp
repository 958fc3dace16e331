#include "allocations.hpp"

#include <atomic>
#include <cstdlib>

static std::atomic<std::size_t> count{0};

std::size_t allocations() { return count; }

#ifdef __GLIBC__
// Definitions of the program take precedence over those of the C library, also for calls from other
// libraries.
extern "C" {

void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t number, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);

void* malloc(std::size_t size) {
    ++count;
    return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) {
    ++count;
    return __libc_calloc(number, size);
}
void* realloc(void* memory, std::size_t size) {
    ++count;
    return __libc_realloc(memory, size);
}

}
#endif
