#include "roadgen/geodesy/geoid_file.h"

#include <exception>
#include <filesystem>

#include <GeographicLib/Geoid.hpp>

namespace roadgen {

struct GeoidFile::Impl {
  Impl(const std::string& name, const std::string& folder) : geoid(name, folder) {}
  GeographicLib::Geoid geoid;
};

GeoidFile::GeoidFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GeoidFile::~GeoidFile() = default;
GeoidFile::GeoidFile(GeoidFile&&) noexcept = default;
GeoidFile& GeoidFile::operator=(GeoidFile&&) noexcept = default;

Result<GeoidFile> GeoidFile::open(const std::string& path) {
  const std::filesystem::path file = std::filesystem::absolute(path);
  try {
    return GeoidFile(std::make_unique<Impl>(file.stem().string(), file.parent_path().string()));
  } catch (const std::exception& e) {
    return Error{ErrorCode::kParse, std::string("not a geoid that can be read: ") + e.what(), path};
  }
}

double GeoidFile::undulation_m(double longitude_deg, double latitude_deg) const {
  return impl_->geoid(latitude_deg, longitude_deg);
}

}  // namespace roadgen
