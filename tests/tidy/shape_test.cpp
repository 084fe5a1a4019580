// SPDX-License-Identifier: MIT
// Runs the rules of shape over the repository, and each over samples that break it.
#include "tests/tidy/shape.h"

#include <algorithm>
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/tidy/repository.h"

namespace karst::tidy {
namespace {

TEST(ShapeTest, FoldersAreSmall) {
  Findings findings;
  check_folder_sizes(repository(), large_folders(), findings);
  EXPECT_TRUE(findings.empty()) << listing(findings);
}

TEST(ShapeTest, NoCircles) {
  Findings findings;
  check_circles(repository(), circles(), findings);
  EXPECT_TRUE(findings.empty()) << listing(findings);
}

TEST(ShapeTest, ClassesAreSmall) {
  const std::vector<Source> sources = repository();
  Findings findings;
  check_class_sizes(sources, large_classes(), findings);
  EXPECT_TRUE(findings.empty()) << listing(findings);

  std::vector<ClassSize> all;
  for (const Source& source : sources) {
    if (!source.path.ends_with(".h") && !source.path.ends_with(".cpp")) continue;
    for (ClassSize& size : class_sizes(source)) all.push_back(std::move(size));
  }
  EXPECT_GT(all.size(), 50u);
  std::stable_sort(all.begin(), all.end(),
                   [](const ClassSize& a, const ClassSize& b) { return a.members > b.members; });
  for (std::size_t i = 0; i < std::min<std::size_t>(all.size(), 10); ++i) {
    std::printf("%3d members  %s (%s)\n", all[i].members, all[i].name.c_str(), all[i].path.c_str());
  }
}

// --- the rules themselves

TEST(ShapeRule, FolderSizes) {
  std::vector<Source> sources;
  for (std::size_t i = 0; i < kMostFiles; ++i) sources.push_back({"app/f" + std::to_string(i) + ".h", ""});
  sources.push_back({"app/CMakeLists.txt", ""});
  sources.push_back({"app/view/a.h", ""});
  const auto count = [&](const Exceptions& exceptions) {
    Findings findings;
    check_folder_sizes(sources, exceptions, findings);
    return findings.size();
  };
  EXPECT_EQ(count({}), 0u);
  EXPECT_EQ(count({{"app", 13, "a reason"}}), 1u) << "an exception that is not needed";
  sources.push_back({"app/more.h", ""});
  EXPECT_EQ(count({}), 1u);
  EXPECT_EQ(count({{"app", 13, "a reason"}}), 0u);
  sources.push_back({"app/still_more.h", ""});
  EXPECT_EQ(count({{"app", 13, "a reason"}}), 1u) << "more than the exception allows";
}

TEST(ShapeRule, Circles) {
  const auto count = [](const std::vector<Source>& sources, const Exceptions& exceptions = {}) {
    Findings findings;
    check_circles(sources, exceptions, findings);
    return findings.size();
  };
  const Source a{"app/a/x.h", "#include \"app/b/y.h\"\n#include \"app/a/z.h\"\n"};
  const Source b{"app/b/y.h", "#include \"app/c/y.h\"\n"};
  EXPECT_EQ(count({a, b}), 0u);
  EXPECT_EQ(count({a, b, {"app/c/y.h", "#include <vector>\n"}}), 0u);
  EXPECT_EQ(count({a, b, {"app/c/y.h", "#include \"app/a/x.h\"\n"}}), 3u) << "the long way round";
  const Source back{"app/b/y.h", "#include \"app/a/x.h\"\n"};
  EXPECT_EQ(count({a, back}), 2u);
  EXPECT_EQ(count({a, back}, {{"app/a - app/b", 0, "a reason"}}), 0u);
  EXPECT_EQ(count({a}, {{"app/a - app/b", 0, "a reason"}}), 1u) << "an exception that is not needed";
}

std::string sizes_of(const std::string& text) {
  std::string result;
  for (const ClassSize& size : class_sizes({"a.h", text})) {
    result += size.name + ":" + std::to_string(size.members) + " ";
  }
  return result;
}

TEST(ShapeRule, MembersAreCounted) {
  EXPECT_EQ(sizes_of("class A {\n int a_;\n};\n"), "A:1 ");
  EXPECT_EQ(sizes_of("class A final : public B {\n public:\n  int a_ = f(1, 2);\n  T<int, 3> b_{};\n};\n"),
            "A:2 ");
  EXPECT_EQ(sizes_of("class A { int a_, b_ = 1; float c_[3]{}; std::function<void(int)> d_; };"), "A:4 ");
  EXPECT_EQ(sizes_of("class A { std::array<int, (1 << 3)> a_; B& b_; const char* c_ = \";{\"; };"), "A:3 ");
  EXPECT_EQ(sizes_of("template <class T>\nclass [[nodiscard]] A {\n private:\n  T a_;\n};\n"), "A:1 ");
  EXPECT_EQ(sizes_of("class A { class B { int x_; } b_; int y_; };"), "A:2 B:1 ");
  EXPECT_EQ(sizes_of("namespace n {\nstruct A { int a_; };\nclass B { int b_; };\n}\n"), "A:1 B:1 ");
}

TEST(ShapeRule, WhatIsNoMemberIsNotCounted) {
  EXPECT_EQ(sizes_of("class A { void f(int x_); int g() const { return a_; } int a_; };"), "A:1 ");
  EXPECT_EQ(sizes_of("class A { A() : a_(1), b_{2} { f(); }\n int a_; int b_; };"), "A:2 ");
  EXPECT_EQ(sizes_of("class A { enum class E { x_, y_ };\n E e_; };"), "A:1 ");
  EXPECT_EQ(sizes_of("class A { static int s_; using t_ = int; // int c_;\n /* int d_; */ int a_; };"),
            "A:1 ");
  EXPECT_EQ(sizes_of("class A;\nint f() { int x_; return x_; }\nstruct P { int x; };\n"), "");
}

TEST(ShapeRule, ClassSizes) {
  std::string text = "class A {\n";
  for (int i = 0; i < kMostMembers; ++i) text += "  int a" + std::to_string(i) + "_ = 0;\n";
  const auto count = [&](const std::string& more, const Exceptions& exceptions) {
    Findings findings;
    check_class_sizes({{"app/a.h", text + more + "};\n"}}, exceptions, findings);
    return findings.size();
  };
  EXPECT_EQ(count("", {}), 0u);
  EXPECT_EQ(count("  int more_;\n", {}), 1u);
  EXPECT_EQ(count("  int more_;\n", {{"A", 21, "a reason"}}), 0u);
  EXPECT_EQ(count("  int more_;\n  int still_more_;\n", {{"A", 21, "a reason"}}), 1u)
      << "more than the exception allows";
  EXPECT_EQ(count("", {{"A", 21, "a reason"}}), 1u) << "an exception that is not needed";
}

}  // namespace
}  // namespace karst::tidy
