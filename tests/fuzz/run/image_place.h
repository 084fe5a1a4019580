// SPDX-License-Identifier: MIT
// Files for readers that take names: in a folder of this process.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <span>
#include <string>

namespace karst {

class ImagePlace {
 public:
  ImagePlace() { std::filesystem::create_directories(folder_); }
  ~ImagePlace() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  ImagePlace(const ImagePlace&) = delete;
  ImagePlace& operator=(const ImagePlace&) = delete;

  std::string write(const char* name, std::span<const std::byte> bytes) const {
    const std::string path = folder_ / name;
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return path;
  }

 private:
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("karst-fuzz-" + std::to_string(getpid()));
};

}  // namespace karst
