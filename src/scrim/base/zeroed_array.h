// SPDX-License-Identifier: Apache-2.0
// Large buffers of numbers that start as zeros, in pages of 2 MB where the system has them. A sweep goes through its
// buffers again and again, and with small pages it spends a tenth of its time on page faults and address look-ups.
#pragma once

#include <cstddef>
#include <utility>

namespace scrim {

/// Maps pages of zeros, which take no memory until they are touched. Throws Error (memory).
void* mapZeros(std::size_t bytes);
void unmapZeros(void* memory, std::size_t bytes) noexcept;

template <class T>
class ZeroedArray {
  public:
    ZeroedArray() = default;
    explicit ZeroedArray(std::size_t size)
        : m_data(size > 0 ? static_cast<T*>(mapZeros(size * sizeof(T))) : nullptr), m_size(size) {}
    ~ZeroedArray() {
        if (m_data) unmapZeros(m_data, m_size * sizeof(T));
    }
    ZeroedArray(ZeroedArray&& other) noexcept
        : m_data(std::exchange(other.m_data, nullptr)), m_size(std::exchange(other.m_size, 0)) {}
    ZeroedArray& operator=(ZeroedArray&& other) noexcept {
        std::swap(m_data, other.m_data);
        std::swap(m_size, other.m_size);
        return *this;
    }

    T* data() { return m_data; }
    const T* data() const { return m_data; }
    std::size_t size() const { return m_size; }
    T& operator[](std::size_t i) { return m_data[i]; }
    const T& operator[](std::size_t i) const { return m_data[i]; }

  private:
    T* m_data = nullptr;  // aligned to pages
    std::size_t m_size = 0;
};

}  // namespace scrim
