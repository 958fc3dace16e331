/// Errors: exceptions, or results that hold them.
#pragma once

#include <cstdlib>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "../robot_dynamics.h"

#ifndef ROBOT_DYNAMICS_NO_EXCEPTIONS
#include <stdexcept>
#endif

// The two forms of the functions have different types, so they have different names for the linker.
#ifdef ROBOT_DYNAMICS_NO_EXCEPTIONS
#define ROBOT_DYNAMICS_NAMESPACE inline namespace with_results
#else
#define ROBOT_DYNAMICS_NAMESPACE inline namespace with_exceptions
#endif

namespace robot_dynamics {
ROBOT_DYNAMICS_NAMESPACE {

/// The status of a failed call and its text, which names the argument, the coordinate and the value.
class Error
#ifndef ROBOT_DYNAMICS_NO_EXCEPTIONS
    : public std::runtime_error
#endif
{
public:
    /// The last error of the calling thread.
    explicit Error(rd_status status) : Error(status, rd_error_message()) {}

#ifndef ROBOT_DYNAMICS_NO_EXCEPTIONS
    Error(rd_status status, const std::string& message) : std::runtime_error(message), status_(status) {}
#else
    Error(rd_status status, std::string message) : message_(std::move(message)), status_(status) {}

    /// The text.
    const char* what() const noexcept { return message_.c_str(); }
#endif

    /// The status: see `rd_status`.
    rd_status status() const noexcept { return status_; }

private:
#ifdef ROBOT_DYNAMICS_NO_EXCEPTIONS
    std::string message_;
#endif
    rd_status status_;
};

#ifdef ROBOT_DYNAMICS_NO_EXCEPTIONS

/// A value, or the error that prevented it.
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : held_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : held_(std::in_place_index<1>, std::move(error)) {}

    /// Whether there is a value.
    bool has_value() const noexcept { return held_.index() == 0; }
    explicit operator bool() const noexcept { return has_value(); }

    /// The value. The program is aborted if there is none.
    T& value() & { return has_value() ? std::get<0>(held_) : (std::abort(), std::get<0>(held_)); }
    T&& value() && { return std::move(value()); }
    T& operator*() & { return value(); }
    T&& operator*() && { return std::move(value()); }
    T* operator->() { return &value(); }

    /// The error. The program is aborted if there is none.
    const Error& error() const { return has_value() ? (std::abort(), std::get<1>(held_)) : std::get<1>(held_); }

private:
    std::variant<T, Error> held_;
};

/// Success, or an error.
template <>
class [[nodiscard]] Result<void> {
public:
    Result() = default;
    Result(Error error) : held_(std::in_place_index<1>, std::move(error)) {}

    bool has_value() const noexcept { return held_.index() == 0; }
    explicit operator bool() const noexcept { return has_value(); }
    const Error& error() const { return has_value() ? (std::abort(), std::get<1>(held_)) : std::get<1>(held_); }

private:
    std::variant<std::monostate, Error> held_;
};

#else

/// The type that a function returns: the value itself, as errors are exceptions.
template <class T>
using Result = T;

#endif

namespace detail {

/// The value of a call, or its error. The value is a reference, since the call that is the other argument may
/// still write into it.
template <class T>
Result<std::decay_t<T>> finish(rd_status status, T&& value) {
    if (status != RD_STATUS_OK) {
#ifdef ROBOT_DYNAMICS_NO_EXCEPTIONS
        return Error(status);
#else
        throw Error(status);
#endif
    }
    return std::forward<T>(value);
}

/// The end of a call without a value.
inline Result<void> finish(rd_status status) {
    if (status != RD_STATUS_OK) {
#ifdef ROBOT_DYNAMICS_NO_EXCEPTIONS
        return Error(status);
#else
        throw Error(status);
#endif
    }
#ifdef ROBOT_DYNAMICS_NO_EXCEPTIONS
    return {};
#endif
}

/// A handle that frees its object.
template <class H, rd_status (*Free)(H)>
class Owner {
public:
    Owner() noexcept = default;
    explicit Owner(H handle) noexcept : handle_(handle) {}
    Owner(Owner&& other) noexcept : handle_(std::exchange(other.handle_, H{0})) {}
    Owner& operator=(Owner&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    Owner(const Owner&) = delete;
    Owner& operator=(const Owner&) = delete;
    ~Owner() {
        if (handle_.id != 0) {
            Free(handle_);
        }
    }

    /// The handle, for functions of `robot_dynamics.h`.
    H get() const noexcept { return handle_; }

    /// The place of the handle, for functions that make the object.
    H* put() noexcept { return &handle_; }

private:
    H handle_{0};
};

/// A text of the library as a string; empty for null.
inline std::string text(const char* text) { return text ? text : ""; }

}  // namespace detail
}
}  // namespace robot_dynamics
