// Pictures in files. Needs no OpenGL.
#include "roadgen/render/image.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

namespace roadgen {
namespace {

class ImageTest : public ::testing::Test {
 protected:
  ImageTest() {
    folder_ = std::filesystem::temp_directory_path() / ("roadgen-images-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~ImageTest() override { std::filesystem::remove_all(folder_); }

  size_t files() const { return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder_), {})); }
  static std::string bytes(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  }

  std::filesystem::path folder_;
};

Image8 ramp(int channels) {
  Image8 image(7, 5, channels);
  for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<std::uint8_t>(i * 37 + i / 11);
  return image;
}

TEST_F(ImageTest, PngRoundTripsExactlyForEveryChannelCount) {
  for (int channels = 1; channels <= 4; ++channels) {
    const Image8 image = ramp(channels);
    const Status status = write_png(folder_ / "a.png", image);
    ASSERT_TRUE(status.ok()) << status.error().text();
    const auto back = read_image8(folder_ / "a.png");
    ASSERT_TRUE(back.ok()) << back.error().text();
    EXPECT_EQ(back->channels, channels);
    EXPECT_EQ(back->pixels, image.pixels) << channels;
  }
  EXPECT_EQ(files(), 1u);
}

TEST_F(ImageTest, WritingTwiceGivesTheSameBytes) {
  ASSERT_TRUE(write_png(folder_ / "a.png", ramp(3)).ok());
  ASSERT_TRUE(write_png(folder_ / "b.png", ramp(3)).ok());
  EXPECT_EQ(bytes(folder_ / "a.png"), bytes(folder_ / "b.png"));
  ASSERT_TRUE(write_exr(folder_ / "a.exr", ImageF(3, 2, 1)).ok());
  ASSERT_TRUE(write_exr(folder_ / "b.exr", ImageF(3, 2, 1)).ok());
  EXPECT_EQ(bytes(folder_ / "a.exr"), bytes(folder_ / "b.exr"));
}

TEST_F(ImageTest, ExrKeepsNamedChannelsAndEveryFloat) {
  ImageF image(4, 3, 5);
  image.channel_names = {"road", "s", "t", "lane", "z"};
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    image.pixels[i] = std::ldexp(1.0f + 0.1f * static_cast<float>(i), static_cast<int>(i) - 30);
  }
  image.at(1, 1, 4) = std::numeric_limits<float>::infinity();
  image.at(2, 1, 1) = std::numeric_limits<float>::quiet_NaN();
  image.at(0, 0, 3) = -16777215.0f;
  const Status status = write_exr(folder_ / "a.exr", image);
  ASSERT_TRUE(status.ok()) << status.error().text();
  const auto back = read_image_float(folder_ / "a.exr");
  ASSERT_TRUE(back.ok()) << back.error().text();
  ASSERT_EQ(back->channels, 5);
  for (int channel = 0; channel < 5; ++channel) {
    const int there = back->channel_index(image.channel_names[static_cast<size_t>(channel)]);
    ASSERT_GE(there, 0);
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 4; ++x) {
        const float a = image.at(x, y, channel), b = back->at(x, y, there);
        EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << a << " " << b;
      }
    }
  }
  EXPECT_EQ(back->channel_index("none"), -1);
}

TEST_F(ImageTest, UnwritablePathsAreClearErrorsAndLeaveNothing) {
  const Status nowhere = write_png(folder_ / "none" / "a.png", ramp(3));
  ASSERT_FALSE(nowhere.ok());
  EXPECT_EQ(nowhere.error().code, ErrorCode::kIo);
  EXPECT_EQ(nowhere.error().file, (folder_ / "none" / "a.png").string());
  EXPECT_NE(nowhere.error().message.find("does not exist"), std::string::npos) << nowhere.error().text();
  EXPECT_FALSE(write_png(folder_, ramp(3)).ok());
  EXPECT_EQ(files(), 0u);
}

TEST_F(ImageTest, AFailedWriteKeepsTheFormerFile) {
  ASSERT_TRUE(write_png(folder_ / "a.png", ramp(3)).ok());
  const std::string before = bytes(folder_ / "a.png");
  Image8 broken = ramp(3);
  broken.pixels.pop_back();
  EXPECT_FALSE(write_png(folder_ / "a.png", broken).ok());
  EXPECT_FALSE(write_png(folder_ / "a.png", Image8()).ok());
  EXPECT_FALSE(write_png(folder_ / "a.png", Image8(2, 2, 5)).ok());
  EXPECT_EQ(bytes(folder_ / "a.png"), before);
  EXPECT_EQ(files(), 1u);
}

TEST_F(ImageTest, UnreadableFilesAreErrors) {
  EXPECT_EQ(read_image8(folder_ / "none.png").error().code, ErrorCode::kIo);
  std::ofstream(folder_ / "text.png") << "no picture";
  EXPECT_EQ(read_image_float(folder_ / "text.png").error().code, ErrorCode::kIo);
  ASSERT_TRUE(write_png(folder_ / "a.png", ramp(4)).ok());
  std::filesystem::resize_file(folder_ / "a.png", std::filesystem::file_size(folder_ / "a.png") / 2);
  EXPECT_EQ(read_image8(folder_ / "a.png").error().code, ErrorCode::kIo);
}

TEST_F(ImageTest, RelativePathsWork) {
  const auto former = std::filesystem::current_path();
  std::filesystem::current_path(folder_);
  EXPECT_TRUE(write_png("a.png", ramp(1)).ok());
  std::filesystem::current_path(former);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "a.png"));
}

TEST_F(ImageTest, CompareFindsMaxMeanAndPlace) {
  Image8 a(4, 2, 3);
  Image8 b = a;
  b.at(2, 1, 1) = 24;
  b.at(0, 0, 0) = 12;
  const auto difference = compare(a, b);
  ASSERT_TRUE(difference.ok());
  EXPECT_EQ(difference->max, 24);
  EXPECT_EQ(difference->mean, 1.5);
  EXPECT_EQ(difference->x, 2);
  EXPECT_EQ(difference->y, 1);
  EXPECT_FALSE(compare(a, Image8(4, 2, 1)).ok());
}

TEST_F(ImageTest, CompareTreatsInfinitiesAsValues) {
  const float infinity = std::numeric_limits<float>::infinity();
  ImageF a(1, 1, 1), b(1, 1, 1);
  a.pixels[0] = b.pixels[0] = infinity;
  EXPECT_EQ(compare(a, b)->max, 0);
  b.pixels[0] = 1;
  EXPECT_EQ(compare(a, b)->max, infinity);
  a.pixels[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(compare(a, b)->max, infinity);
  EXPECT_EQ(compare(a, a)->max, 0);
}

TEST_F(ImageTest, FlippingTwiceIsTheIdentity) {
  const Image8 image = ramp(3);
  Image8 turned = image;
  flip(turned);
  for (int y = 0; y < image.height; ++y) EXPECT_EQ(turned.at(2, y, 1), image.at(2, image.height - 1 - y, 1));
  flip(turned);
  EXPECT_EQ(turned.pixels, image.pixels);
}

}  // namespace
}  // namespace roadgen
