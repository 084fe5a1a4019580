// SPDX-License-Identifier: MIT
// Numbers and texts as the bytes that go to a child of this program and come back (child.h).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace karst::bake {

// Appends to bytes that outlive it.
class WriteMessage {
 public:
  explicit WriteMessage(std::vector<std::byte>& bytes) : bytes_(bytes) {}

  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto view = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), view.begin(), view.end());
  }
  void put_text(std::string_view text) {
    put(std::uint64_t{text.size()});
    const auto view = std::as_bytes(std::span(text));
    bytes_.insert(bytes_.end(), view.begin(), view.end());
  }
  template <class T>
  void put_all(const std::vector<T>& values) {
    put(std::uint64_t{values.size()});
    for (const T& value : values) put(value);
  }
  void put_texts(const std::vector<std::string>& texts) {
    put(std::uint64_t{texts.size()});
    for (const std::string& text : texts) put_text(text);
  }

 private:
  std::vector<std::byte>& bytes_;
};

// Takes in the order in which it was put. Past the end: zeros and nothing, and whole() is false.
class ReadMessage {
 public:
  explicit ReadMessage(std::span<const std::byte> bytes) : rest_(bytes) {}

  bool whole() const { return whole_; }

  template <class T>
  void take(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (!has(sizeof value)) return;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_ = rest_.subspan(sizeof value);
  }
  void take_text(std::string& text) {
    const std::uint64_t size = take_count();
    if (!has(size)) return;
    text.assign(reinterpret_cast<const char*>(rest_.data()), static_cast<std::size_t>(size));
    rest_ = rest_.subspan(static_cast<std::size_t>(size));
  }
  template <class T>
  void take_all(std::vector<T>& values) {
    values.resize(static_cast<std::size_t>(std::min<std::uint64_t>(take_count(), rest_.size())));
    for (T& value : values) take(value);
  }
  void take_texts(std::vector<std::string>& texts) {
    texts.resize(static_cast<std::size_t>(std::min<std::uint64_t>(take_count(), rest_.size())));
    for (std::string& text : texts) take_text(text);
  }

 private:
  bool has(std::uint64_t size) {
    if (size <= rest_.size()) return true;
    whole_ = false;
    rest_ = {};
    return false;
  }
  std::uint64_t take_count() {
    std::uint64_t count = 0;
    take(count);
    return count;
  }

  std::span<const std::byte> rest_;
  bool whole_ = true;
};

}  // namespace karst::bake
