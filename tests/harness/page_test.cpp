#include "harness/report/page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "harness/report/page_modules.hpp"

namespace penumbra {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A folder of page parts of its own, named by PENUMBRA_PAGES.
class PageTest : public ::testing::Test {
  protected:
    void SetUp() override {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        folder_ =
            std::filesystem::path(::testing::TempDir()) / (std::string("page_") + test->name());
        std::filesystem::create_directories(folder_);
        setenv("PENUMBRA_PAGES", folder_.c_str(), 1);
        write("page.css", "body { margin: 0 }");
        write("own.css", "p { margin: 0 }");
        write("own.html", "<p>hello</p>\n");
        write("own.js", "import {one} from \"./one.js\";\nwindow.sum = one() + 1;\n");
        write("one.js", "export function one() { return 1; }\n");
    }
    void TearDown() override {
        unsetenv("PENUMBRA_PAGES");
        std::filesystem::remove_all(folder_);
    }
    void write(const std::string& name, const std::string& text) {
        std::ofstream(folder_ / name) << text;
    }
    std::string failure(const std::string& entry) {
        try {
            joinModules(folder_, entry);
        } catch (const std::runtime_error& e) {
            return e.what();
        }
        return "nothing was thrown";
    }

    std::filesystem::path folder_;
    PageSource source_{
        .title = "a <b> & c", .markup = "own.html", .styles = {"own.css"}, .script = "own.js"};
};

TEST(PageData, TextCannotEndItsElement) {
    const nlohmann::ordered_json hostile = {{"</script><script>alert(1)</script>", "<!--"}};
    const std::string element = dataElement(jsonData("x", hostile));
    EXPECT_EQ(std::count(element.begin(), element.end(), '<'), 2) << element;
    const std::size_t begin = element.find('>') + 1;
    const std::string text = element.substr(begin, element.rfind("</") - begin);
    EXPECT_EQ(nlohmann::ordered_json::parse(text), hostile);
}

TEST(PageData, BytesThatAreNoUtf8AreReplaced) {
    const PageData data = jsonData("x", nlohmann::ordered_json("a\xff"
                                                               "b"));
    EXPECT_EQ(nlohmann::json::parse(data.text), "a\uFFFDb");
}

TEST(PageData, WhatCouldRunOrEscapeIsRefused) {
    EXPECT_THROW(dataElement({"x", "text/javascript", ""}), std::invalid_argument);
    EXPECT_THROW(dataElement({"x", "a\"b", ""}), std::invalid_argument);
    EXPECT_THROW(dataElement({"x y", "text/plain", ""}), std::invalid_argument);
    EXPECT_THROW(dataElement({"x", "text/plain", "</script>"}), std::invalid_argument);
}

TEST(PageData, Base64OfRfc4648) {
    const auto encoded = [](std::string_view text) {
        return base64({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
    };
    EXPECT_EQ(encoded(""), "");
    EXPECT_EQ(encoded("f"), "Zg==");
    EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
}

TEST_F(PageTest, ShellHoldsItsPartsAndEscapesTheTitle) {
    const std::array data{jsonData("rows", {1, 2})};
    const PageShell shell = pageShell(source_, data);
    EXPECT_THAT(shell.head, HasSubstr("<title>a &lt;b&gt; &amp; c</title>"));
    EXPECT_THAT(shell.head, HasSubstr("body { margin: 0 }p { margin: 0 }"));
    EXPECT_THAT(shell.head, HasSubstr("<p>hello</p>"));
    EXPECT_THAT(shell.head, HasSubstr("id=\"rows\">[1,2]</script>"));
    EXPECT_LT(shell.head.find("id=\"rows\""), shell.head.find("window.sum"));
    EXPECT_THAT(shell.head, Not(HasSubstr("Chart")));
}

TEST_F(PageTest, PolicyNamesTheScriptByItsHash) {
    write("own.js", "");
    const std::string head = pageShell(source_, {}).head;
    std::smatch match;
    ASSERT_TRUE(std::regex_search(head, match, std::regex("script-src ([^;]*);")));
    // openssl dgst -sha256 -binary | base64 of what stands between the tags.
    EXPECT_EQ(match[1], "'sha256-Q2BzkVJro2F31kFT0HxRIHuW1NQQqPJZl86XCeiAZYY=' ");
    EXPECT_THAT(head, HasSubstr("default-src 'none'"));
    EXPECT_THAT(head, Not(HasSubstr("unsafe")));
}

TEST_F(PageTest, ChartComesWithItsLicence) {
    source_.charts = true;
    const std::string head = pageShell(source_, {}).head;
    EXPECT_THAT(head, HasSubstr("THE SOFTWARE IS PROVIDED"));
    EXPECT_THAT(head, HasSubstr("Chart.js v"));
}

TEST_F(PageTest, APartThatWouldEndItsElementIsRefused) {
    write("one.js", "export function one() { return \"</script>\"; }\n");
    EXPECT_THROW(pageShell(source_, {}), std::runtime_error);
}

TEST_F(PageTest, ModulesAreJoinedOnceAndInOrder) {
    write("two.js", "import {one} from \"./one.js\";\nexport const two = one() + one();\n");
    write("own.js",
          "import {two} from \"./two.js\";\nimport {\n  one\n} from \"./one.js\";\nwindow.x = "
          "two;\n");
    EXPECT_EQ(joinModules(folder_, "own.js"),
              "// ---- one.js ----\nconst module2 = (() => {\n"
              "function one() { return 1; }\nreturn {one};\n})();\n"
              "// ---- two.js ----\nconst module1 = (() => {\n"
              "const {one} = module2;\nconst two = one() + one();\nreturn {two};\n})();\n"
              "// ---- own.js ----\nconst module0 = (() => {\n"
              "const {two} = module1;\nconst {\n  one\n} = module2;\nwindow.x = two;\n"
              "return {};\n})();\n");
}

TEST_F(PageTest, WhatModulesMayNotSayIsNamedByLine) {
    write("star.js", "const a = 1;\nimport * as b from \"./one.js\";\n");
    EXPECT_THAT(failure("star.js"), HasSubstr("star.js:2: expected import {a, b}"));
    write("default.js", "export default 1;\n");
    EXPECT_THAT(failure("default.js"), HasSubstr("default.js:1: expected export before"));
    write("lost.js", "import {a} from \"./nowhere.js\";\n");
    EXPECT_THAT(failure("lost.js"), HasSubstr("nowhere.js"));
}

}  // namespace
}  // namespace penumbra
