// Internal, not installed: which pages of some data lie where in a buffer of bounded size. The page used the longest time
// ago makes room for a new one, but none that the batch at hand draws from: where those fill the buffer, it is drawn first.
#pragma once

#include <cstdint>
#include <list>
#include <optional>
#include <vector>

namespace roadgen {

class PagePool {
 public:
  PagePool() = default;
  // Requires: slots > 0 where there are pages.
  PagePool(std::uint32_t pages, std::uint32_t slots) : slot_of_page_(pages) {
    for (std::uint32_t i = 0; i < slots; ++i) slots_.push_back({i, kNoPage, 0});
  }

  void begin_batch() { ++batch_; }
  // How often a page was given another's place.
  std::uint64_t replacements() const { return replacements_; }

  struct Placed {
    std::uint32_t slot;
    bool is_new;  // its data have to be written there
  };
  // The place of a page, which stays there for this batch. None: there is no room before the next.
  std::optional<Placed> place(std::uint32_t page) {
    auto& known = slot_of_page_[page];
    const bool is_new = !known;
    if (is_new) {
      if (slots_.front().batch == batch_) return std::nullopt;
      Slot& slot = slots_.front();
      if (slot.page != kNoPage) {
        slot_of_page_[slot.page].reset();
        ++replacements_;
      }
      slot.page = page;
      known = slots_.begin();
    }
    Slot& slot = **known;
    if (slot.batch != batch_) {
      slot.batch = batch_;
      slots_.splice(slots_.end(), slots_, *known);
    }
    return Placed{slot.index, is_new};
  }

 private:
  static constexpr std::uint32_t kNoPage = ~0u;
  struct Slot {
    std::uint32_t index;  // of the page's place in the buffer
    std::uint32_t page;
    std::uint64_t batch;  // the last one that draws from it
  };
  std::list<Slot> slots_;  // least recently used first
  std::vector<std::optional<std::list<Slot>::iterator>> slot_of_page_;
  std::uint64_t batch_ = 1, replacements_ = 0;
};

}  // namespace roadgen
