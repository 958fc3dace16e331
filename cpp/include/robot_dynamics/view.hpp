/// Views of arrays: arguments and results without copies.
#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <type_traits>
#include <utility>
#include <vector>

#include "result.hpp"

#if defined(ROBOT_DYNAMICS_EIGEN) || defined(EIGEN_CORE_H) || defined(EIGEN_CORE_MODULE_H)
#define ROBOT_DYNAMICS_HAS_EIGEN
#include <Eigen/Core>
#endif

namespace robot_dynamics {
ROBOT_DYNAMICS_NAMESPACE {
namespace detail {

template <class T, class = void>
struct is_eigen : std::false_type {};

template <class T>
struct is_eigen<T, std::void_t<decltype(std::decay_t<T>::InnerStrideAtCompileTime)>> : std::true_type {};

/// The first entry of a container, whose entries must follow each other row by row.
template <class C>
auto entries(C& container) {
    if constexpr (is_eigen<C>::value) {
        using E = std::decay_t<C>;
        static_assert(E::InnerStrideAtCompileTime == 1, "the entries of the Eigen object have gaps: copy it");
        static_assert(E::IsVectorAtCompileTime || E::IsRowMajor,
                      "matrices are row-major: use robot_dynamics::RowMajorMatrix");
        if (!E::IsVectorAtCompileTime && container.outerStride() != container.innerSize()) {
            // A block of a matrix. A null pointer with a length is an error of the call.
            return decltype(container.data()){nullptr};
        }
    }
    return container.data();
}

template <class T, class C>
using if_entries_of = std::enable_if_t<
    std::is_convertible_v<decltype(std::declval<C&>().data()), T*> &&
    std::is_convertible_v<decltype(std::declval<C&>().size()), std::size_t>>;

}  // namespace detail

/// A view of numbers of the caller: `std::vector`, `std::array`, a C array, an Eigen vector or row-major matrix,
/// or a pointer with a length. It does not own them.
template <class T>
class BasicView {
public:
    BasicView() noexcept = default;
    BasicView(T* data, std::size_t size) noexcept : data_(data), size_(size) {}

    template <std::size_t N>
    BasicView(T (&array)[N]) noexcept : data_(array), size_(N) {}

    template <class C, class = detail::if_entries_of<T, C>>
    BasicView(C& container) noexcept
        : data_(detail::entries(container)), size_(static_cast<std::size_t>(container.size())) {}

    /// A temporary, which lives until the end of the call.
    template <class C, class U = T, class = std::enable_if_t<std::is_const_v<U>>,
              class = detail::if_entries_of<T, const C>>
    BasicView(const C& container) noexcept
        : data_(detail::entries(container)), size_(static_cast<std::size_t>(container.size())) {}

    /// A list of numbers as an argument: `{0.1, 0.2}`. It lives until the end of the call.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Winit-list-lifetime"
#endif
    template <class U = T, class = std::enable_if_t<std::is_const_v<U>>>
    BasicView(std::initializer_list<std::remove_const_t<T>> list) noexcept
        : data_(list.begin()), size_(list.size()) {}
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

    T* data() const noexcept { return data_; }
    std::size_t size() const noexcept { return size_; }
    bool empty() const noexcept { return size_ == 0; }
    T* begin() const noexcept { return data_; }
    T* end() const noexcept { return data_ + size_; }
    T& operator[](std::size_t index) const noexcept { return data_[index]; }

private:
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

/// Numbers that a function reads.
using View = BasicView<const double>;
/// Numbers that a function writes.
using MutableView = BasicView<double>;

/// A vector that a function returns.
using Vector = std::vector<double>;

/// A matrix that a function returns, row by row.
class Matrix {
public:
    Matrix() = default;
    Matrix(std::size_t rows, std::size_t columns)
        : rows_(rows), columns_(columns), entries_(rows * columns) {}

    std::size_t rows() const noexcept { return rows_; }
    std::size_t columns() const noexcept { return columns_; }
    std::size_t size() const noexcept { return entries_.size(); }
    double* data() noexcept { return entries_.data(); }
    const double* data() const noexcept { return entries_.data(); }
    double& operator()(std::size_t row, std::size_t column) { return entries_[row * columns_ + column]; }
    double operator()(std::size_t row, std::size_t column) const { return entries_[row * columns_ + column]; }

private:
    std::size_t rows_ = 0;
    std::size_t columns_ = 0;
    std::vector<double> entries_;
};

/// A pose: x_world = R x_frame + p. The numbers are R by rows, then p [m].
struct Pose {
    std::array<double, 12> numbers{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};

    /// An entry of R.
    double rotation(std::size_t row, std::size_t column) const { return numbers[3 * row + column]; }
    /// p [m].
    std::array<double, 3> translation() const { return {numbers[9], numbers[10], numbers[11]}; }
    double* data() noexcept { return numbers.data(); }
    const double* data() const noexcept { return numbers.data(); }
    std::size_t size() const noexcept { return numbers.size(); }
};

#ifdef ROBOT_DYNAMICS_HAS_EIGEN
/// The type of Eigen matrices that results are written into.
using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A returned matrix as an Eigen matrix, without a copy; valid as long as the matrix.
inline Eigen::Map<const RowMajorMatrix> map(const Matrix& matrix) {
    return {matrix.data(), static_cast<Eigen::Index>(matrix.rows()), static_cast<Eigen::Index>(matrix.columns())};
}

/// A returned vector as an Eigen vector, without a copy; valid as long as the vector.
inline Eigen::Map<const Eigen::VectorXd> map(const Vector& vector) {
    return {vector.data(), static_cast<Eigen::Index>(vector.size())};
}
#endif

}
}  // namespace robot_dynamics
