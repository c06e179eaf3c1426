#include "terrain/ground_loader.h"

#include <algorithm>

namespace roadgen {

GroundLoader::GroundLoader(std::shared_ptr<const GroundSource> source)
    : source_(std::move(source)), loaded_(source_->tiles().size()) {
  if (!source_->is_in_memory()) {
    thread_ = std::thread([this] { run(); });
    return;
  }
  for (std::size_t i = 0; i < loaded_.size(); ++i) {
    loaded_[i] = static_cast<std::uint32_t>(source_->tiles()[i].bands.size());
  }
}

GroundLoader::~GroundLoader() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ends_ = true;
  }
  wished_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::uint32_t GroundLoader::loaded(std::size_t tile) const { return loaded_[tile].load(std::memory_order_acquire); }

std::size_t GroundLoader::loaded_bytes() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return bytes_ + reading_bytes_;
}

void GroundLoader::set_loaded(std::size_t tile, std::uint32_t bands) {
  const GroundTile& t = source_->tiles()[tile];
  bytes_ += t.bytes(bands);
  bytes_ -= t.bytes(loaded(tile));
  loaded_[tile].store(bands, std::memory_order_release);
}

// The thread may load the same at the same time; then it is read twice.
Status GroundLoader::load(std::size_t tile, std::uint32_t bands) {
  const std::uint32_t have = loaded(tile);
  if (have >= bands) return Done{};
  if (Status s = source_->load(tile, have, bands); !s) return s;
  const std::lock_guard<std::mutex> lock(mutex_);
  set_loaded(tile, std::max(bands, loaded(tile)));
  return Done{};
}

void GroundLoader::release(std::size_t tile) {
  if (source_->is_in_memory()) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  set_loaded(tile, 0);
  source_->release(tile);
}

Status GroundLoader::wish(const std::vector<Wish>& wishes, std::size_t most_bytes) {
  if (source_->is_in_memory()) return Done{};
  std::vector<Wish> granted;
  std::vector<bool> is_granted(loaded_.size(), false);
  std::size_t bytes = 0;
  for (const Wish& wish : wishes) {
    const std::size_t of_tile = source_->tiles()[wish.tile].bytes(std::max(wish.bands, loaded(wish.tile)));
    if (bytes + of_tile > most_bytes) break;
    bytes += of_tile;
    granted.push_back(wish);
    is_granted[wish.tile] = true;
  }
  Status failed = Done{};
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    // Room for what is granted.
    for (std::size_t i = 0; i < loaded_.size(); ++i) {
      if (!is_granted[i]) bytes += source_->tiles()[i].bytes(loaded(i));
    }
    for (std::size_t i = 0; bytes > most_bytes && i < loaded_.size(); ++i) {
      if (is_granted[i] || loaded(i) == 0) continue;
      bytes -= source_->tiles()[i].bytes(loaded(i));
      set_loaded(i, 0);
      source_->release(i);
    }
    most_bytes_ = most_bytes;
    wishes_ = std::move(granted);
    std::swap(failed, failed_);
  }
  wished_.notify_one();
  return failed;
}

std::optional<GroundLoader::Wish> GroundLoader::next() const {
  const auto found =
      std::find_if(wishes_.begin(), wishes_.end(), [&](const Wish& w) { return loaded(w.tile) < w.bands; });
  if (found == wishes_.end()) return std::nullopt;
  // What load() has taken in the meantime counts too.
  const GroundTile& tile = source_->tiles()[found->tile];
  const std::uint32_t have = loaded(found->tile);
  return bytes_ + tile.bytes(have + 1) - tile.bytes(have) > most_bytes_ ? std::nullopt : std::optional(*found);
}

void GroundLoader::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    std::optional<Wish> wish;
    wished_.wait(lock, [&] { return ends_ || (wish = next()).has_value(); });
    if (ends_) return;
    // Band by band, so that each is seen as soon as it is there, and new wishes are heard.
    const std::uint32_t have = loaded(wish->tile);
    const GroundTile& tile = source_->tiles()[wish->tile];
    reading_bytes_ = tile.bytes(have + 1) - tile.bytes(have);
    lock.unlock();
    const Status read = source_->load(wish->tile, have, have + 1);
    lock.lock();
    reading_bytes_ = 0;
    if (!read) {
      failed_ = read;
      wishes_.clear();
    } else if (loaded(wish->tile) == have) {
      set_loaded(wish->tile, have + 1);
    }
  }
}

}  // namespace roadgen
