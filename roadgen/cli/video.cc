#include "roadgen/cli/video.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <utility>
#include <vector>

#include "roadgen/export/atomic_file.h"

extern char** environ;

namespace roadgen::cli {

Result<VideoWriter> VideoWriter::open(const std::string& path, int width, int height, int frames_per_second) {
  if (Status s = check_writable(path); !s) return s.error();
  VideoWriter writer;
  writer.path_ = path;
  writer.temporary_ = path + ".part" + std::to_string(getpid());
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  const std::string rate = std::to_string(frames_per_second);
  const std::vector<std::string> arguments = {"ffmpeg",
                                              "-hide_banner",
                                              "-loglevel",
                                              "error",
                                              "-y",
                                              "-f",
                                              "rawvideo",
                                              "-pix_fmt",
                                              "rgba",
                                              "-s",
                                              size,
                                              "-r",
                                              rate,
                                              "-i",
                                              "pipe:0",
                                              "-vf",
                                              "crop=trunc(iw/2)*2:trunc(ih/2)*2",
                                              "-c:v",
                                              "libx264",
                                              "-preset",
                                              "veryfast",
                                              "-crf",
                                              "21",
                                              "-pix_fmt",
                                              "yuv420p",
                                              "-movflags",
                                              "+faststart",
                                              "-f",
                                              "mp4",
                                              writer.temporary_};
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);

  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return Error{ErrorCode::kIo, std::string("no pipe: ") + std::strerror(errno)};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  const int fault = posix_spawnp(&writer.child_, "ffmpeg", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[0]);
  writer.pipe_ = ends[1];
  if (fault != 0) {
    writer.child_ = -1;
    return Error{ErrorCode::kIo,
                 std::string("cannot start ffmpeg (") + std::strerror(fault) +
                     "); install the package ffmpeg, or give a folder to get single pictures",
                 path};
  }
  // A write to an ffmpeg that died is to be an error, not the end of this process.
  std::signal(SIGPIPE, SIG_IGN);
  return writer;
}

VideoWriter::VideoWriter(VideoWriter&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::move(other.temporary_)),
      pipe_(std::exchange(other.pipe_, -1)),
      child_(std::exchange(other.child_, -1)) {}

VideoWriter::~VideoWriter() {
  if (pipe_ >= 0) close(pipe_);
  if (child_ > 0) {
    waitpid(child_, nullptr, 0);
    std::remove(temporary_.c_str());
  }
}

Status VideoWriter::add(const Image8& picture) {
  const std::uint8_t* at = picture.pixels.data();
  std::size_t left = picture.pixels.size();
  while (left > 0) {
    const ssize_t written = write(pipe_, at, left);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return Error{ErrorCode::kIo, "ffmpeg stopped taking pictures; its message stands above", path_};
    at += written;
    left -= static_cast<std::size_t>(written);
  }
  return Done{};
}

Status VideoWriter::finish() {
  close(std::exchange(pipe_, -1));
  int status = 0;
  waitpid(std::exchange(child_, -1), &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    std::remove(temporary_.c_str());
    return Error{ErrorCode::kIo, "ffmpeg could not write the video; its message stands above", path_};
  }
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) {
    const std::string reason = std::strerror(errno);
    std::remove(temporary_.c_str());
    return Error{ErrorCode::kIo, "cannot be written: " + reason, path_};
  }
  return Done{};
}

}  // namespace roadgen::cli
