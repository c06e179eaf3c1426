#include "roadgen/geodesy/projection.h"

#include <dlfcn.h>
#include <proj.h>

#include <cmath>
#include <string_view>

namespace roadgen {
namespace {

// What is called of PROJ. The library is loaded when a network first needs it: with the 40 others that it needs and its
// data base it takes as much memory as the import of a town.
#define ROADGEN_PROJ_FUNCTIONS(X)     \
  X(proj_context_create)              \
  X(proj_context_destroy)             \
  X(proj_create)                      \
  X(proj_create_crs_to_crs_from_pj)   \
  X(proj_crs_get_coordinate_system)   \
  X(proj_crs_get_sub_crs)             \
  X(proj_cs_get_axis_count)           \
  X(proj_cs_get_axis_info)            \
  X(proj_destroy)                     \
  X(proj_get_source_crs)              \
  X(proj_get_type)                    \
  X(proj_log_func)                    \
  X(proj_normalize_for_visualization) \
  X(proj_trans)

struct Proj {
#define ROADGEN_MEMBER(name) decltype(&::name) name = nullptr;
  ROADGEN_PROJ_FUNCTIONS(ROADGEN_MEMBER)
#undef ROADGEN_MEMBER
  std::string failure;  // why it is not there; empty where it is
};

Proj load_proj() {
  Proj proj;
  void* library = ::dlopen(ROADGEN_PROJ_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  const auto fail = [&] {
    const char* why = ::dlerror();
    proj.failure = why ? why : ROADGEN_PROJ_LIBRARY " lacks a function";
  };
  if (!library) {
    fail();
    return proj;
  }
#define ROADGEN_LOAD(name)                                                  \
  proj.name = reinterpret_cast<decltype(&::name)>(::dlsym(library, #name)); \
  if (!proj.name && proj.failure.empty()) fail();
  ROADGEN_PROJ_FUNCTIONS(ROADGEN_LOAD)
#undef ROADGEN_LOAD
  return proj;
}

// It stays loaded.
const Proj& proj() {
  static const Proj loaded = load_proj();
  return loaded;
}

struct FreeContext {
  void operator()(PJ_CONTEXT* context) const { proj().proj_context_destroy(context); }
};
struct FreePj {
  void operator()(PJ* pj) const { proj().proj_destroy(pj); }
};
using Context = std::unique_ptr<PJ_CONTEXT, FreeContext>;
using Pj = std::unique_ptr<PJ, FreePj>;

// PROJ's first message, on one line, instead of standard error.
void take_message(void* message, int, const char* text) {
  auto& kept = *static_cast<std::string*>(message);
  if (!kept.empty()) return;
  constexpr std::string_view kSpeaker = "proj_create: ";
  if (std::string_view(text).starts_with(kSpeaker)) text += kSpeaker.size();
  for (const char* c = text; *c; ++c) kept += *c == '\n' || *c == '\r' ? ' ' : *c;
}

// A PROJ string without a projection: PROJ would search its data base for it, for a third of a second.
bool names_no_system(const std::string& definition) {
  return definition.starts_with('+') && definition.find("proj=") == std::string::npos &&
         definition.find("init=") == std::string::npos;
}

// The system alone, without a shift of its datum or heights.
Pj plain_system(PJ_CONTEXT* context, Pj system) {
  for (;;) {
    const PJ_TYPE type = proj().proj_get_type(system.get());
    Pj inner;
    if (type == PJ_TYPE_BOUND_CRS) inner.reset(proj().proj_get_source_crs(context, system.get()));
    if (type == PJ_TYPE_COMPOUND_CRS) inner.reset(proj().proj_crs_get_sub_crs(context, system.get(), 0));
    if (!inner) return system;
    system = std::move(inner);
  }
}

bool is_in_metres(PJ_CONTEXT* context, Pj system) {
  const Pj plain = plain_system(context, std::move(system));
  if (proj().proj_get_type(plain.get()) != PJ_TYPE_PROJECTED_CRS) return false;
  const Pj axes(proj().proj_crs_get_coordinate_system(context, plain.get()));
  if (!axes || proj().proj_cs_get_axis_count(context, axes.get()) < 2) return false;
  for (int i = 0; i < 2; ++i) {
    double factor = 0;
    if (!proj().proj_cs_get_axis_info(context, axes.get(), i, nullptr, nullptr, nullptr, &factor, nullptr, nullptr,
                                      nullptr) ||
        factor != 1) {
      return false;
    }
  }
  return true;
}

}  // namespace

struct Projection::Impl {
  Context context;
  Pj change;  // from the plane to degrees
};

Projection::Projection(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Projection::~Projection() = default;
Projection::Projection(Projection&&) noexcept = default;
Projection& Projection::operator=(Projection&&) noexcept = default;

Result<Projection> Projection::make(const std::string& definition) {
  if (names_no_system(definition)) return Error{ErrorCode::kData, "it lacks +proj"};
  if (!proj().failure.empty()) {
    return Error{ErrorCode::kIo, "it cannot be used without the library PROJ: " + proj().failure};
  }
  auto impl = std::make_unique<Impl>();
  impl->context.reset(proj().proj_context_create());
  PJ_CONTEXT* const context = impl->context.get();
  std::string message;
  proj().proj_log_func(context, &message, take_message);
  const auto fail = [&](const std::string& what) { return Error{ErrorCode::kData, message.empty() ? what : message}; };

  // A PROJ string is a system only where it says so; otherwise it is an operation.
  const bool is_string = definition.find("proj=") != std::string::npos && definition.find('[') == std::string::npos &&
                         definition.find("type=crs") == std::string::npos;
  const auto system_of = [&] {
    return Pj(proj().proj_create(context, (definition + (is_string ? " +type=crs" : "")).c_str()));
  };
  const Pj system = system_of();
  if (!system) return fail("PROJ does not know it");
  if (!is_in_metres(context, system_of())) return fail("it is not a projected system in metres");
  const Pj wgs84(proj().proj_create(context, "EPSG:4326"));
  if (!wgs84) return fail("PROJ does not know WGS84");
  const Pj change(proj().proj_create_crs_to_crs_from_pj(context, system.get(), wgs84.get(), nullptr, nullptr));
  if (!change) return fail("PROJ knows no way from it to WGS84");
  // x before y and longitude before latitude, whatever the systems' own order.
  impl->change.reset(proj().proj_normalize_for_visualization(context, change.get()));
  if (!impl->change) return fail("PROJ knows no way from it to WGS84");
  proj().proj_log_func(context, nullptr, [](void*, int, const char*) {});
  return Projection(std::move(impl));
}

glm::dvec2 Projection::to_plane_m(glm::dvec2 longitude_latitude_deg) {
  const PJ_COORD from{{longitude_latitude_deg.x, longitude_latitude_deg.y, 0, HUGE_VAL}};
  const PJ_COORD to = proj().proj_trans(impl_->change.get(), PJ_INV, from);
  return {to.xy.x, to.xy.y};
}

glm::dvec2 Projection::to_degrees(glm::dvec2 plane_m) {
  const PJ_COORD to = proj().proj_trans(impl_->change.get(), PJ_FWD, {{plane_m.x, plane_m.y, 0, HUGE_VAL}});
  return {to.xy.x, to.xy.y};
}

}  // namespace roadgen
