#include "roadgen/fit/solver.h"

#include <dlfcn.h>

namespace roadgen {
namespace {

Result<const FitSolver*> load_solver() {
  // Found by the run path of the program or library that this is a part of. AddressSanitizer puts itself before dlopen,
  // which then searches by its run path.
  void* library = ::dlmopen(LM_ID_BASE, ROADGEN_FIT_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  if (const void* solver = library ? ::dlsym(library, "roadgen_fit_solver") : nullptr) {
    return static_cast<const FitSolver*>(solver);
  }
  const char* why = ::dlerror();
  return Error{ErrorCode::kIo, std::string("the fit's library cannot be loaded: ") + (why ? why : "no reason given") +
                                   "; it belongs beside roadgen's other files"};
}

}  // namespace

Result<const FitSolver*> fit_solver() {
  static const Result<const FitSolver*> loaded = load_solver();
  return loaded;
}

}  // namespace roadgen
