// A value that most of its owners lack: one pointer where there is none.
#pragma once

#include <memory>

namespace roadgen {

template <class T>
class Rare {
 public:
  Rare() = default;
  Rare(const Rare& other) : held_(other.held_ ? std::make_unique<T>(*other.held_) : nullptr) {}
  Rare(Rare&&) noexcept = default;
  Rare& operator=(const Rare& other) {
    held_ = other.held_ ? std::make_unique<T>(*other.held_) : nullptr;
    return *this;
  }
  Rare& operator=(Rare&&) noexcept = default;

  // The value, or an empty one that all share.
  const T& operator*() const {
    static const T none{};
    return held_ ? *held_ : none;
  }
  const T* operator->() const { return &**this; }
  // The owner's own, made where there is none.
  T& edit() {
    if (!held_) held_ = std::make_unique<T>();
    return *held_;
  }
  // None and an empty one are the same.
  bool operator==(const Rare& other) const { return **this == *other; }

 private:
  std::unique_ptr<T> held_;
};

}  // namespace roadgen
