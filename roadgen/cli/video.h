// Pictures one after the other as an .mp4 (H.264), by the program ffmpeg; the file appears whole or not at all.
#pragma once

#include <string>

#include <sys/types.h>

#include "roadgen/render/image.h"
#include "roadgen/road/result.h"

namespace roadgen::cli {

class VideoWriter {
 public:
  // Requires: width, height, frames_per_second > 0. Odd sizes lose their last column or row.
  // Errors: kIo: ffmpeg cannot be started, or the folder cannot be written.
  static Result<VideoWriter> open(const std::string& path, int width, int height, int frames_per_second);
  VideoWriter(VideoWriter&& other) noexcept;
  VideoWriter& operator=(VideoWriter&&) = delete;
  ~VideoWriter();  // without finish(): nothing stays behind

  // Requires: RGBA of the size given to open. Errors: kIo: ffmpeg gave up.
  Status add(const Image8& picture);
  Status finish();

 private:
  VideoWriter() = default;
  std::string path_, temporary_;
  int pipe_ = -1;
  pid_t child_ = -1;
};

}  // namespace roadgen::cli
