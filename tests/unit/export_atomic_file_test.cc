#include <gtest/gtest.h>

#include <filesystem>

#include "roadgen/export/atomic_file.h"
#include "tests/temporary_folder.h"

namespace roadgen {
namespace {

TEST(AtomicFile, HoldsTheBytesAndNothingElseStands) {
  const test::TemporaryFolder folder;
  const std::string bytes("a\0b\n", 4), path = folder.path("out");
  ASSERT_TRUE(write_file(path, bytes).ok());
  EXPECT_EQ(test::text_of(path), bytes);
  ASSERT_TRUE(write_file(path, "shorter").ok());
  EXPECT_EQ(test::text_of(path), "shorter");
  EXPECT_EQ(folder.count(), 1u);
}

TEST(AtomicFile, SymbolicLinkStaysAndItsFileIsReplaced) {
  const test::TemporaryFolder folder;
  folder.put("real", "old");
  std::filesystem::create_symlink("real", folder.path("link"));
  ASSERT_TRUE(write_file(folder.path("link"), "new").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(folder.path("link")));
  EXPECT_EQ(test::text_of(folder.path("real")), "new");
}

TEST(AtomicFile, WhatCannotBeWrittenIsAnErrorThatNamesIt) {
  const test::TemporaryFolder folder;
  const std::string file = folder.put("file", "x");
  std::filesystem::create_directory(folder.path("sub"));
  for (const std::string& path :
       {folder.path("none/out"), file + "/out", folder.path("sub"), std::string("/dev/null"), std::string()}) {
    for (const Status& status : {check_writable(path), write_file(path, "text")}) {
      ASSERT_FALSE(status.ok()) << path;
      EXPECT_EQ(status.error().code, ErrorCode::kIo);
      EXPECT_NE(status.error().text().find(path), std::string::npos);
    }
  }
  EXPECT_EQ(folder.count(), 2u);
}

}  // namespace
}  // namespace roadgen
