// Output files that appear whole or not at all.
#pragma once

#include <functional>
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

// Likewise the bytes that `write` hands over piece by piece, none of which is kept in memory; pieces are best some 64 KB
// or larger.
using TakeBytes = std::function<void(std::string_view)>;
Status write_file(const std::string& path, const std::function<void(const TakeBytes&)>& write);

}  // namespace roadgen
