// Stub for tests: a buffer between a thread that may wait and one that must not.
#pragma once

#include <mutex>
#include <utility>

namespace realtime_tools {

template <class T>
class RealtimeBuffer {
public:
    RealtimeBuffer() = default;

    T* readFromRT() {
        std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
        if (lock.owns_lock() && is_new_) {
            std::swap(current_, next_);
            is_new_ = false;
        }
        return &values_[current_];
    }
    void writeFromNonRT(const T& value) {
        std::lock_guard<std::mutex> lock(mutex_);
        values_[next_] = value;
        is_new_ = true;
    }

private:
    std::mutex mutex_;
    T values_[2];
    int current_ = 0;
    int next_ = 1;
    bool is_new_ = false;
};

}  // namespace realtime_tools
