// SPDX-License-Identifier: MIT
#include "tests/view/fake_screen.h"

#include <fcntl.h>
#include <png.h>
#include <signal.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "tests/support/test_world.h"

extern char** environ;

namespace karst::test {
namespace {

constexpr useconds_t kPoll_us = 2000;

std::vector<std::byte> small_world() {
  TestWorld world = TestWorld::hills();
  world.roughen(2, 9, 500);
  return world.file();
}

template <class Condition>
bool until(double seconds, Condition condition) {
  const double end = seconds_now() + seconds;
  for (;;) {
    if (condition()) return true;
    if (seconds_now() > end) return false;
    usleep(kPoll_us);
  }
}

}  // namespace

double seconds_now() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

FakeScreen::FakeScreen() : world_(folder_.write("world.karst", small_world())) {
  if (mkfifo(folder_.path("uevent").c_str(), 0600) != 0) throw std::runtime_error("no FIFO");
  uevent_ = open(folder_.path("uevent").c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
  set("card connected master atomic flips modes=320x240");
}

FakeScreen::~FakeScreen() {
  if (pid_ > 0) stop(SIGKILL);
  close(uevent_);
}

void FakeScreen::set(const std::string& words) {
  folder_.write("state.new", words);
  std::rename(folder_.path("state.new").c_str(), folder_.path("state").c_str());
}

void FakeScreen::tell() const {
  const char byte = 'u';
  if (write(uevent_, &byte, 1) != 1) throw std::runtime_error("the FIFO is full");
}

void FakeScreen::start(std::vector<std::string> words, const std::string& fail, bool supervise, int input) {
  if (std::find(words.begin(), words.end(), "--navigate") == words.end())
    words.insert(words.begin(), {"--navigate", "none"});
  words.insert(words.begin(), {KARST_APP_PATH, "view", world_, "--seat", "direct"});
  if (!supervise) words.insert(words.begin() + 3, "--no-supervisor");
  std::vector<std::string> settings = {
      "LD_PRELOAD=" KARST_FAKE_KMS_PATH, "KARST_FAKE_STATE=" + folder_.path("state"),
      "KARST_FAKE_UEVENT=" + folder_.path("uevent"), "KARST_FAKE_SCANOUT=" + folder_.path("scan_out"),
      "KARST_FAKE_CALLS=" + folder_.path("calls"), "KARST_FAKE_FAIL=" + fail,
      // LeakSanitizer and friends must come first, which a preload is not.
      "ASAN_OPTIONS=verify_asan_link_order=0:detect_leaks=0"};
  for (char** e = environ; *e != nullptr; ++e) settings.emplace_back(*e);
  const auto pointers = [](std::vector<std::string>& texts) {
    std::vector<char*> result;
    for (std::string& text : texts) result.push_back(text.data());
    result.push_back(nullptr);
    return result;
  };
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (input >= 0) {
    posix_spawn_file_actions_adddup2(&actions, input, 0);
  } else {
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  }
  posix_spawn_file_actions_addopen(&actions, 1, folder_.path("out").c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                   0600);
  posix_spawn_file_actions_addopen(&actions, 2, folder_.path("err").c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                   0600);
  const int error = posix_spawn(&pid_, words[0].c_str(), &actions, nullptr, pointers(words).data(),
                                pointers(settings).data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("cannot start karst");
}

bool FakeScreen::wait_for(const std::string& text, int times, double seconds) {
  return until(seconds, [&] {
    const std::string all = messages();
    int found = 0;
    for (std::size_t at = all.find(text); at != std::string::npos; at = all.find(text, at + 1)) ++found;
    return found >= times;
  });
}

int FakeScreen::wait(double seconds) {
  int status = 0;
  const bool ended = until(seconds, [&] { return waitpid(pid_, &status, WNOHANG) == pid_; });
  if (!ended) {
    kill(pid_, SIGKILL);
    waitpid(pid_, &status, 0);
  }
  pid_ = -1;
  if (!ended) return -1;
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

bool FakeScreen::ends_within(double seconds) const {
  return until(seconds, [&] {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid == pid_;
  });
}

bool FakeScreen::listens() const {
  return until(10, [&] {
    const std::string status = read_text("/proc/" + std::to_string(pid_) + "/status");
    const std::size_t at = status.find("SigBlk:");
    const unsigned long blocked =
        at == std::string::npos ? 0 : std::stoul(status.substr(at + 7), nullptr, 16);
    return (blocked >> (SIGHUP - 1) & 1) != 0 && (blocked >> (SIGTERM - 1) & 1) != 0;
  });
}

int FakeScreen::stop(int signal_number) {
  kill(pid_, signal_number);
  return wait();
}

void FakeScreen::send(int signal_number) const {
  if (pid_ > 0) kill(pid_, signal_number);
}

std::string FakeScreen::messages() const {
  return read_text(folder_.path("err"));
}

ScanOut FakeScreen::scan_out() const {
  std::ifstream file(folder_.path("scan_out"), std::ios::binary);
  ScanOut result;
  file >> result.width >> result.height;
  file.get();
  result.rgba.assign(std::istreambuf_iterator<char>(file), {});
  return result;
}

std::string FakeScreen::statistics() {
  const std::string path = folder_.path("stats.json");
  std::filesystem::remove(path);
  send(SIGHUP);
  until(10, [&] { return std::filesystem::exists(path); });
  return read_text(path);
}

long FakeScreen::calls() const {
  return std::atol(read_text(folder_.path("calls")).c_str());
}

ScanOut FakeScreen::rendered(int width, int height, const std::vector<std::string>& more) const {
  const std::string file = folder_.path("rendered.png");
  std::vector<std::string> words = {"render", world_,   "-o",
                                    file,     "--size", std::to_string(width) + "x" + std::to_string(height)};
  words.insert(words.end(), more.begin(), more.end());
  const ProcessResult result = run_process(KARST_APP_PATH, words);
  if (result.code != 0) throw std::runtime_error("karst render: " + result.err);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, file.c_str()) == 0) throw std::runtime_error("no picture");
  image.format = PNG_FORMAT_RGBA;
  ScanOut picture{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  picture.rgba.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr) == 0) {
    throw std::runtime_error("a broken picture");
  }
  return picture;
}

int largest_difference(const ScanOut& a, const ScanOut& b) {
  if (a.width != b.width || a.height != b.height || a.rgba.size() != b.rgba.size() || a.rgba.empty())
    return 256;
  int most = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    if (i % 4 != 3) most = std::max(most, std::abs(int{a.rgba[i]} - int{b.rgba[i]}));
  }
  return most;
}

ScanOut turned_left(const ScanOut& picture, int quarter_turns) {
  ScanOut result = picture;
  for (int turn = 0; turn < quarter_turns; ++turn) {
    const ScanOut from = result;
    result.width = from.height;
    result.height = from.width;
    for (int y = 0; y < result.height; ++y) {
      for (int x = 0; x < result.width; ++x) {
        const auto to = (static_cast<std::size_t>(y) * static_cast<std::size_t>(result.width) +
                         static_cast<std::size_t>(x)) *
                        4;
        // What was right is at the top.
        const auto source = (static_cast<std::size_t>(x) * static_cast<std::size_t>(from.width) +
                             static_cast<std::size_t>(from.width - 1 - y)) *
                            4;
        std::memcpy(&result.rgba[to], &from.rgba[source], 4);
      }
    }
  }
  return result;
}

double number_of(const std::string& json, const std::string& name) {
  const std::size_t at = json.find("\"" + name + "\":");
  if (at == std::string::npos) return -1;
  return std::atof(json.c_str() + at + name.size() + 3);
}

}  // namespace karst::test
