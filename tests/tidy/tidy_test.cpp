// SPDX-License-Identifier: MIT
// Runs the house rules over the repository, and each rule over a sample that breaks it.
#include "tests/tidy/rules.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "tests/tidy/repository.h"

namespace karst::tidy {
namespace {

namespace fs = std::filesystem;

using Rule = void (*)(const Source&, Findings&);

void expect_clean(Rule rule, bool text_only) {
  Findings findings;
  const std::vector<Source> sources = repository();
  EXPECT_GT(sources.size(), 20u) << "the repository was not found in " << KARST_SOURCE_DIR;
  for (const Source& source : sources) {
    if (!text_only || is_text(source.path)) rule(source, findings);
  }
  EXPECT_TRUE(findings.empty()) << listing(findings);
}

TEST(RepositoryTest, NoStrayFiles) {
  expect_clean(check_known, false);
}
TEST(RepositoryTest, Text) {
  expect_clean(check_text, true);
}
TEST(RepositoryTest, Licence) {
  expect_clean(check_licence, true);
}
TEST(RepositoryTest, HeaderGuards) {
  expect_clean(check_header_guard, true);
}
TEST(RepositoryTest, Includes) {
  expect_clean(check_includes, true);
}
TEST(RepositoryTest, Words) {
  expect_clean(check_words, true);
}

bool exists(const std::string& path) {
  return fs::exists(fs::path(KARST_SOURCE_DIR) / path);
}

TEST(RepositoryTest, OwnHeaderFirst) {
  Findings findings;
  for (const Source& source : repository()) check_own_header(source, exists, findings);
  EXPECT_TRUE(findings.empty()) << listing(findings);
}

TEST(RepositoryTest, Links) {
  Findings findings;
  for (const Source& source : repository()) check_links(source, exists, findings);
  EXPECT_TRUE(findings.empty()) << listing(findings);
}

TEST(RepositoryTest, DocumentsNameWhatIsThere) {
  const std::vector<Source> sources = repository();
  std::string paths = "/";  // each as "/path" and a newline
  std::string words;
  for (const Source& source : sources) {
    paths += source.path + "\n/";
    if (is_text(source.path) && !source.path.ends_with(".md")) words += source.text;
  }
  const auto has_path = [&](const std::string& path) {
    return paths.find("/" + path + (path.ends_with("/") ? "" : "\n")) != std::string::npos;
  };
  const auto has_word = [&](const std::string& word) { return words.find(word) != std::string::npos; };
  Findings findings;
  for (const Source& source : sources) check_names(source, has_path, has_word, findings);
  EXPECT_TRUE(findings.empty()) << listing(findings);
}

// --- the rules themselves

int count(Rule rule, const std::string& path, const std::string& text) {
  Findings findings;
  rule({path, text}, findings);
  return static_cast<int>(findings.size());
}

TEST(RuleTest, StrayFiles) {
  for (const char* good : {"README.md", "dev", ".ci/run", "terrain/base/arena.h", "terrain/CMakeLists.txt",
                           "gles_shaders/terrain.vert", "examples/simulator/a.cpp", "package/a.pc.in",
                           "docs/images/canyon.png", "docs/images/a.svg", "tests/unit/a_test.cpp"}) {
    EXPECT_EQ(count(check_known, good, ""), 0) << good;
  }
  for (const char* bad : {"notes.txt", "terrain/stray.h", "terrain/misc/a.h", "terrain/base/a.cc",
                          "renderer/a.cpp.orig", "docs/a.pdf", "tests/unit/core", "scripts/a.sh", ".ci/other",
                          "app/a b.cpp", "examples/a.karst", ".vscode/x.json"}) {
    EXPECT_EQ(count(check_known, bad, ""), 1) << bad;
  }
}

TEST(RuleTest, Text) {
  const std::string limit(kMaxColumns, 'x');
  EXPECT_EQ(count(check_text, "a.h", limit + "\n"), 0);
  EXPECT_EQ(count(check_text, "a.h", limit + "x\n"), 1);
  std::string accented;
  for (int i = 0; i < kMaxColumns; ++i) accented += "\xc3\xa9";
  EXPECT_EQ(count(check_text, "a.h", accented + "\n"), 0);
  EXPECT_EQ(count(check_text, "a.md", "|" + limit + "|\n"), 0);
  EXPECT_EQ(count(check_text, "a.md", "-" + limit + "-\n"), 1);
  EXPECT_EQ(count(check_text, "a.h", "a\tb\n"), 1);
  EXPECT_EQ(count(check_text, "a.h", "a \n"), 1);
  EXPECT_EQ(count(check_text, "a.h", "a\r\n"), 1);
  EXPECT_EQ(count(check_text, "a.h", "a"), 1);
  EXPECT_EQ(count(check_text, "a.h", ""), 1);
  std::string lines;
  for (int i = 0; i < kMaxLines; ++i) lines += "\n";
  EXPECT_EQ(count(check_text, "a.h", lines), 0);
  EXPECT_EQ(count(check_text, "a.h", lines + "\n"), 1);
}

TEST(RuleTest, Licence) {
  const std::string line = "SPDX-License-Identifier: MIT\n";
  EXPECT_EQ(count(check_licence, "app/a.cpp", "// " + line), 0);
  EXPECT_EQ(count(check_licence, "app/CMakeLists.txt", "# " + line), 0);
  EXPECT_EQ(count(check_licence, "dev", "#!/bin/bash\n# " + line), 0);
  EXPECT_EQ(count(check_licence, "gles_shaders/a.frag", "#version 300 es\n// " + line), 0);
  EXPECT_EQ(count(check_licence, "LICENSE", "MIT\n"), 0);
  EXPECT_EQ(count(check_licence, "app/a.cpp", "\n// " + line), 1);
  EXPECT_EQ(count(check_licence, "app/a.cpp", ""), 1);
  EXPECT_EQ(count(check_licence, "gles_shaders/a.frag", "#version 300 es\n"), 1);
  EXPECT_EQ(count(check_licence, "app/CMakeLists.txt", "// " + line), 1);
  EXPECT_EQ(count(check_licence, "dev", "#!/bin/bash\n"), 1);
}

TEST(RuleTest, HeaderGuard) {
  EXPECT_EQ(count(check_header_guard, "app/a.h", "#pragma once\n"), 0);
  EXPECT_EQ(count(check_header_guard, "app/a.cpp", "\n"), 0);
  EXPECT_EQ(count(check_header_guard, "app/a.h", "#ifndef A\n#define A\n#endif\n"), 1);
}

TEST(RuleTest, FloorsGoDownwards) {
  const auto includes = [](const std::string& path, const std::string& header) {
    return count(check_includes, path, "#include " + header + "\n");
  };
  EXPECT_EQ(includes("terrain/base/a.h", "\"terrain/base/b.h\""), 0);
  EXPECT_EQ(includes("terrain/base/a.h", "\"karst/status.h\""), 0);
  EXPECT_EQ(includes("terrain/world/a.h", "\"terrain/view/b.h\""), 0);
  EXPECT_EQ(includes("terrain/surface/bezier/a.h", "\"terrain/surface/patch.h\""), 0);
  EXPECT_EQ(includes("renderer/passes/a.h", "\"terrain/view/b.h\""), 0);
  EXPECT_EQ(includes("platform/kms/a.h", "\"platform/display.h\""), 0);
  EXPECT_EQ(includes("app/view/a.cpp", "\"platform/b.h\""), 0);
  EXPECT_EQ(includes("bake/a.cpp", "\"platform/base/b.h\""), 0);
  EXPECT_EQ(includes("tests/gl/a_test.cpp", "\"platform/b.h\""), 0);

  EXPECT_EQ(includes("include/karst/a.h", "\"terrain/base/b.h\""), 1);
  EXPECT_EQ(includes("terrain/base/a.h", "\"terrain/field/b.h\""), 1);
  EXPECT_EQ(includes("terrain/field/a.h", "\"terrain/surface/b.h\""), 1);
  EXPECT_EQ(includes("terrain/surface/a.h", "\"terrain/patch/b.h\""), 1);
  EXPECT_EQ(includes("terrain/patch/a.h", "\"terrain/measure/b.h\""), 1);
  EXPECT_EQ(includes("terrain/view/a.h", "\"terrain/lod/b.h\""), 1);
  EXPECT_EQ(includes("terrain/file/a.h", "\"terrain/world/b.h\""), 1);
  EXPECT_EQ(includes("terrain/patch/a.h", "\"renderer/b.h\""), 1);
  EXPECT_EQ(includes("terrain/base/a.h", "\"tests/support/b.h\""), 1);
  EXPECT_EQ(includes("renderer/a.h", "\"platform/b.h\""), 1);
  EXPECT_EQ(includes("platform/a.h", "\"renderer/b.h\""), 1);
  EXPECT_EQ(includes("platform/a.h", "\"terrain/view/b.h\""), 1);
  EXPECT_EQ(includes("platform/base/a.h", "\"platform/b.h\""), 1);
  EXPECT_EQ(includes("bake/a.cpp", "\"platform/b.h\""), 1);
  EXPECT_EQ(includes("bake/main.cpp", "\"app/view/b.h\""), 1);
  EXPECT_EQ(includes("app/a.cpp", "\"tests/support/b.h\""), 1);
  EXPECT_EQ(includes("app/a.cpp", "\"b.h\""), 1);
  EXPECT_EQ(includes("app/a.cpp", "\"../terrain/base/b.h\""), 1);
  EXPECT_EQ(count(check_includes, "terrain/base/a.h", "#  include \"app/b.h\"\n"), 1);
}

TEST(RuleTest, ExamplesIncludeWhatIsInstalled) {
  const auto includes = [](const std::string& header) {
    return count(check_includes, "examples/simulator/a.cpp", "#include " + header + "\n");
  };
  EXPECT_EQ(includes("<karst/karst.h>"), 0);
  EXPECT_EQ(includes("<EGL/egl.h>"), 0);
  EXPECT_EQ(includes("\"painter.h\""), 0);
  EXPECT_EQ(includes("\"terrain/base/b.h\""), 1);
  EXPECT_EQ(includes("<terrain/base/b.h>"), 1);
  EXPECT_EQ(includes("\"../simulator/painter.h\""), 1);
}

TEST(RuleTest, LibrariesStayWhereTheyBelong) {
  const auto includes = [](const std::string& path, const std::string& header) {
    return count(check_includes, path, "#include <" + header + ">\n");
  };
  EXPECT_EQ(includes("terrain/view/a.h", "glm/vec3.hpp"), 0);
  EXPECT_EQ(includes("terrain/view/a.h", "algorithm"), 0);
  EXPECT_EQ(includes("terrain/base/simd.h", "arm_neon.h"), 0);
  EXPECT_EQ(includes("bake/elevation/a.cpp", "OpenImageIO/imageio.h"), 0);
  EXPECT_EQ(includes("bake/elevation/a.cpp", "gdal.h"), 0);
  EXPECT_EQ(includes("renderer/a.cpp", "GLES3/gl3.h"), 0);
  EXPECT_EQ(includes("platform/a.cpp", "EGL/egl.h"), 0);

  EXPECT_EQ(includes("include/karst/a.h", "span"), 0);
  EXPECT_EQ(includes("include/karst/a.h", "glm/vec3.hpp"), 1);
  EXPECT_EQ(includes("include/karst/a.h", "GLES3/gl3.h"), 1);
  EXPECT_EQ(includes("terrain/view/a.h", "GLES3/gl3.h"), 1);
  EXPECT_EQ(includes("terrain/view/a.h", "unistd.h"), 1);
  EXPECT_EQ(includes("terrain/view/a.h", "nlohmann/json.hpp"), 1);
  EXPECT_EQ(includes("terrain/world/a.cpp", "fstream"), 1);
  EXPECT_EQ(includes("terrain/patch/a.cpp", "arm_neon.h"), 1);
  EXPECT_EQ(includes("app/main.cpp", "OpenImageIO/imageio.h"), 1);
  for (const char* header : {"gdal.h", "ogr_srs_api.h", "cpl_conv.h"}) {
    EXPECT_EQ(includes("app/main.cpp", header), 1) << header;
  }
  EXPECT_EQ(includes("renderer/a.cpp", "EGL/egl.h"), 1);
  EXPECT_EQ(includes("platform/a.cpp", "GLES3/gl3.h"), 1);
}

TEST(RuleTest, OwnHeaderFirst) {
  const auto check = [](const std::string& path, const std::string& text) {
    Findings findings;
    check_own_header(
        {path, text}, [](const std::string& p) { return p == "app/a.h"; }, findings);
    return static_cast<int>(findings.size());
  };
  EXPECT_EQ(check("app/a.cpp", "// text\n#include \"app/a.h\"\n\n#include <vector>\n"), 0);
  EXPECT_EQ(check("app/a.h", "#include <vector>\n"), 0);
  EXPECT_EQ(check("app/main.cpp", "#include <vector>\n"), 0);
  EXPECT_EQ(check("app/a.cpp", "#include <vector>\n#include \"app/a.h\"\n"), 1);
  EXPECT_EQ(check("app/a.cpp", "#include \"app/b.h\"\n#include \"app/a.h\"\n"), 1);
  EXPECT_EQ(check("app/a.cpp", "\n"), 1);
}

TEST(RuleTest, Words) {
  const std::string work = std::string("/wo") + "rk";
  const std::string mark = std::string("TO") + "DO";
  EXPECT_EQ(count(check_words, "a.md", "see ../shared/data, docs" + work + ", .." + work + "\n"), 0);
  EXPECT_EQ(count(check_words, "a.md", "the way " + mark + "S is a word of its own\n"), 0);
  EXPECT_EQ(count(check_words, "a.md", work + "/main\n"), 1);
  EXPECT_EQ(count(check_words, "a.cpp", "open(\"" + std::string("/tm") + "p/x\");\n"), 1);
  EXPECT_EQ(count(check_words, "a.cpp", "// " + mark + ": later\n"), 1);
}

TEST(RuleTest, Links) {
  const auto links = [](const std::string& text) {
    Findings findings;
    check_links(
        {"docs/a.md", text},
        [](const std::string& path) { return path == "docs/b.md" || path == "README.md"; }, findings);
    return static_cast<int>(findings.size());
  };
  EXPECT_EQ(links("[b](b.md) and [top](../README.md#part), [web](https://example.org/x), [here](#part)\n"),
            0);
  EXPECT_EQ(links("[b](b.md) and [c](c.md)\n"), 1);
  EXPECT_EQ(links("![picture](images/none.png)\n"), 1);
}

TEST(RuleTest, Names) {
  const auto names = [](const std::string& text) {
    Findings findings;
    const auto has_path = [](const std::string& path) { return path == "app/a.h" || path == "app/"; };
    const auto has_word = [](const std::string& word) { return word == "Part" || word == "create"; };
    check_names({"docs/a.md", text}, has_path, has_word, findings);
    return static_cast<int>(findings.size());
  };
  EXPECT_EQ(names("`app/a.h`, `app/`, `Part::create()`, `Part`, `words`, b/c.h, `build/b.h`, `NAME.txt`\n"),
            0);
  EXPECT_EQ(names("see `app/b.h`\n"), 1);
  EXPECT_EQ(names("see `gone/`\n"), 1);
  EXPECT_EQ(names("    run app/b.sh\n"), 1);
  EXPECT_EQ(names("see `Part::make`\n"), 1);
  EXPECT_EQ(names("see `make_part`\n"), 1);
}

}  // namespace
}  // namespace karst::tidy
