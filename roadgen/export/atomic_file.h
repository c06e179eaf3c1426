// Output files that appear whole or not at all.
#pragma once

#include <string>
#include <string_view>

#include "roadgen/road/result.h"

namespace roadgen {

// Whether path can be written: its folder exists and takes new files, and path itself is new or a regular file. For
// asking before long work; write_file may still fail.
// Errors: kIo with the path, the reason and what to do.
Status check_writable(const std::string& path);

// Puts the bytes into path, replacing a regular file that is there. They are written to a temporary file in the same
// folder and renamed, so that a reader sees the old file or the new one, and a failure leaves nothing behind.
// A symbolic link stays, and the file that it names is replaced.
// Errors: kIo with the path and the reason.
Status write_file(const std::string& path, std::string_view bytes);

}  // namespace roadgen
