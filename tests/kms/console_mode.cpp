// SPDX-License-Identifier: MIT
// console_mode TERMINAL: exits with 0 where it is in text mode and its keyboard types characters.
#include <fcntl.h>
#include <linux/kd.h>
#include <sys/ioctl.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const int fd = open(argv[1], O_RDONLY | O_NOCTTY);
  int display = -1;
  int keyboard = -1;
  if (fd < 0 || ioctl(fd, KDGETMODE, &display) != 0 || ioctl(fd, KDGKBMODE, &keyboard) != 0) {
    std::perror(argv[1]);
    return 2;
  }
  const bool text = display == KD_TEXT;
  const bool typing = keyboard == K_UNICODE || keyboard == K_XLATE;
  std::printf("%s: %s, keyboard %s\n", argv[1], text ? "text" : "graphics", typing ? "on" : "off");
  return text && typing ? 0 : 1;
}
