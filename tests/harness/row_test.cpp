#include "harness/run/row.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>

#include "core/error.hpp"
#include "harness/run/row_check.hpp"

namespace penumbra {
namespace {

class CsvFile : public testing::Test {
  protected:
    CsvFile() {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() /
                  (std::string("penumbra_row_") + info->name() + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
        path = folder_ / "results.csv";
    }
    ~CsvFile() override { std::filesystem::remove_all(folder_); }

    void write(const std::string& text) const { std::ofstream(path, std::ios::binary) << text; }
    std::string read() const {
        std::ifstream file(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    /// The message of the InputError that reading throws, or "" if it does not.
    std::string errorOfReading() const {
        try {
            readCsv(path);
        } catch (const InputError& error) {
            return error.what();
        }
        return {};
    }

    std::filesystem::path path;

  private:
    std::filesystem::path folder_;
};

Row fullRow() {
    Row row;
    row.scene = "two_layers";
    row.frame = 3;
    row.method = "pcf";
    row.setting = "pcf-0a1b2c3d";
    row.params = "taps=16;kernel=\"disc\"";
    row.width = 512;
    row.height = 384;
    row.frameMs = 0.1;
    row.frameMsLow = 1.0 / 3.0;
    row.frameMsHigh = 1e-300;
    row.frameMsMad = std::numeric_limits<double>::denorm_min();
    row.repeats = 9;
    row.unstable = true;
    row.buildMs = 12345678.875;
    row.shadeMs = 5.0;
    row.prepareMs = 2.5;
    row.drawCalls = 7;
    row.triangles = 123456789;
    row.fragments = 1e15 + 1;
    row.maps = 1;
    row.lightTexels = 1024.0 * 1024.0;
    row.textureMib = 4.125;
    row.metrics = {.rmse = 0.01,
                   .mae = 0.02,
                   .bias = -0.03,
                   .p99 = 0.04,
                   .maxError = 1.0,
                   .ssim = -0.25,
                   .flip = 0.125,
                   .rmseLit = 0.05,
                   .rmsePenumbra = 0.06,
                   .rmseUmbra = 0.07,
                   .leakRate = 0.08,
                   .falseShadowRate = 0.0,
                   .noise = 0.005,
                   .flicker = 0.003,
                   .scoredPixels = 200000,
                   .horizonPixels = 17,
                   .nonfinite = 1,
                   .outOfRange = 2,
                   .referenceSe = 1.0 / 1024,
                   .rmseCorrected = 0.009,
                   .penumbraWidthError = -0.75,
                   .penumbraShift = 0.0625};
    row.shadeFetchesPerPixel = 12.5;
    row.effectsSimulated = "penumbra+self_shadow";
    row.effectsSkipped = "alpha_mask";
    row.effectsMissing = "layered_casters";
    row.renderer = "llvmpipe (LLVM 15.0.6, 256 bits)";
    row.threads = 2;
    row.commit = "0123abc";
    return row;
}

Row failedRow() {
    Row row;
    row.scene = "fence";
    row.method = row.setting = "hard";
    row.width = row.height = 64;
    row.status = "failed";
    row.message = "a \"quoted\", torn\r\nmessage,\nwith lines";
    row.threads = 1;
    return row;
}

TEST(CsvHeader, IsTheContract) {
    EXPECT_EQ(csvHeader(),
              "scene,frame,method,setting,params,width,height,status,message,frame_ms,frame_ms_low,"
              "frame_ms_high,frame_ms_mad,repeats,unstable,build_ms,shade_ms,prepare_ms,draw_calls,"
              "triangles,fragments,maps,light_texels,texture_mib,rmse,mae,bias,p99,max_error,ssim,"
              "flip,rmse_lit,rmse_penumbra,rmse_umbra,leak_rate,false_shadow_rate,noise,flicker,"
              "scored_pixels,horizon_pixels,nonfinite,out_of_range,reference_se,effects_simulated,"
              "effects_skipped,effects_missing,renderer,threads,commit,rmse_corrected,"
              "penumbra_width_error,penumbra_shift,shade_fetches_per_pixel");
}

TEST(ToCsv, ShortestNumbersQuotesAndEmptyFields) {
    const std::string line = toCsv(fullRow());
    EXPECT_TRUE(
        line.starts_with("two_layers,3,pcf,pcf-0a1b2c3d,\"taps=16;kernel=\"\"disc\"\"\","
                         "512,384,ok,,0.1,0.3333333333333333,1e-300,5e-324,9,1,"))
        << line;
    EXPECT_TRUE(
        line.ends_with(",\"llvmpipe (LLVM 15.0.6, 256 bits)\",2,0123abc,0.009,-0.75,0.0625,12.5"))
        << line;
}

TEST(ToCsv, ACellThatNeverRanHasNoCounts) {
    Row row = failedRow();
    row.message = "no";
    EXPECT_EQ(toCsv(row), "fence,0,hard,hard,,64,64,failed,no" + std::string(39, ',') + "1,,,,,");
    row.status = "ok";
    EXPECT_NE(toCsv(row).find(",0,0,0,0,"), std::string::npos) << "counts of a measured cell";
}

TEST_F(CsvFile, RoundTripIsExact) {
    const std::vector<Row> rows{fullRow(), failedRow(), Row{}};
    {
        CsvAppender appender(path);
        for (const Row& row : rows) appender.add(row);
    }
    const std::vector<Row> back = readCsv(path);
    ASSERT_EQ(back.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(back[i], rows[i]) << i;
}

TEST_F(CsvFile, NastyStringsSurvive) {
    for (const std::string& nasty :
         {std::string("\""), std::string("\"\""), std::string(","), std::string("\n"),
          std::string("\r\n"), std::string("\r"), std::string("a\"b"), std::string("\"\n\",\"\n"),
          std::string(" spaces "), std::string("Schl\xc3\xbcssel \xe2\x80\xa6"),
          std::string("ends with quote\"")}) {
        Row row = fullRow();
        row.scene = row.message = row.commit = nasty;
        write(csvHeader() + "\n" + toCsv(row) + "\n" + toCsv(failedRow()) + "\n");
        EXPECT_EQ(readCsv(path), (std::vector<Row>{row, failedRow()})) << nasty;
    }
}

TEST_F(CsvFile, WindowsLineEndsAreAccepted) {
    write(csvHeader() + "\r\n" + toCsv(fullRow()) + "\r\n" + toCsv(failedRow()) + "\r\n");
    EXPECT_EQ(readCsv(path), (std::vector<Row>{fullRow(), failedRow()}));
}

TEST_F(CsvFile, LaterColumnsReadWithoutHarm) {
    write(csvHeader() + ",one_more\n" + toCsv(fullRow()) + ",\"x,y\"\n");
    EXPECT_EQ(readCsv(path), std::vector<Row>{fullRow()});
}

TEST_F(CsvFile, EveryTearingPointLosesOnlyTheLastRow) {
    const std::string good = csvHeader() + "\n" + toCsv(fullRow()) + "\n";
    const std::string last = toCsv(failedRow()) + "\n";
    for (std::size_t cut = 0; cut < last.size(); ++cut) {
        write(good + last.substr(0, cut));
        ASSERT_EQ(readCsv(path), std::vector<Row>{fullRow()}) << "cut after " << cut << " bytes";
        { CsvAppender(path).add(failedRow()); }
        ASSERT_EQ(read(), good + last) << "cut after " << cut << " bytes";
    }
}

TEST_F(CsvFile, ATornHeaderStartsAgain) {
    for (const std::size_t cut : {std::size_t{0}, std::size_t{10}, csvHeader().size()}) {
        write(csvHeader().substr(0, cut));
        EXPECT_TRUE(readCsv(path).empty()) << cut;
        { CsvAppender(path).add(fullRow()); }
        EXPECT_EQ(readCsv(path), std::vector<Row>{fullRow()}) << cut;
    }
}

TEST_F(CsvFile, ContinuingKeepsWhatIsThere) {
    { CsvAppender(path).add(fullRow()); }
    { CsvAppender(path).add(failedRow()); }
    EXPECT_EQ(read(), csvHeader() + "\n" + toCsv(fullRow()) + "\n" + toCsv(failedRow()) + "\n");
}

TEST_F(CsvFile, ARowIsInTheFileWhenAddReturns) {
    CsvAppender appender(path);
    EXPECT_EQ(read(), csvHeader() + "\n");
    appender.add(fullRow());
    EXPECT_EQ(readCsv(path), std::vector<Row>{fullRow()});
}

TEST_F(CsvFile, ContinuingUnderOtherColumnsIsRefusedAndTouchesNothing) {
    for (const std::string& text : {std::string("scene,frame\na,0\n"), csvHeader() + ",more\n",
                                    std::string("some notes without a line end")}) {
        write(text);
        EXPECT_THROW(CsvAppender{path}, InputError) << text;
        EXPECT_EQ(read(), text);
    }
}

TEST_F(CsvFile, AnUnwritablePlaceIsAnInputError) {
    EXPECT_THROW(CsvAppender{path.parent_path() / "absent" / "results.csv"}, InputError);
    EXPECT_THROW(readCsv(path), InputError) << "no such file";
}

TEST_F(CsvFile, MalformedLinesAreNamed) {
    // The good row before spans lines 2 to 4: its message holds two newlines.
    const std::string good = csvHeader() + "\n" + toCsv(failedRow()) + "\n";
    const std::string at = path.string() + ":5: ";

    write(good + "a,b,c\n");
    EXPECT_EQ(errorOfReading(), at + "3 fields, expected 53");

    std::string line = toCsv(fullRow());
    line.replace(line.find(",512,"), 5, ",51x2,");
    write(good + line + "\n");
    EXPECT_EQ(errorOfReading(), at + "column width: '51x2' is not a number");

    line = toCsv(fullRow());
    line.replace(line.find(",5e-324,"), 8, ",fast,");
    write(good + line + "\n");
    EXPECT_EQ(errorOfReading(), at + "column frame_ms_mad: 'fast' is not a number");

    write(good + "\"a\"b" + toCsv(fullRow()) + "\n");
    EXPECT_EQ(errorOfReading(), at + "text after a closing quote in column 1");
}

TEST_F(CsvFile, MissingAndRepeatedColumnsAreNamed) {
    std::string header = csvHeader();
    header.replace(header.find(",rmse,"), 6, ",");
    write(header + "\n");
    EXPECT_TRUE(errorOfReading().starts_with(path.string() + ":1: column rmse "))
        << errorOfReading();
    write(csvHeader() + ",p99\n");
    EXPECT_TRUE(errorOfReading().starts_with(path.string() + ":1: column p99 "))
        << errorOfReading();
}

std::string errorOfTable(const std::filesystem::path& path) {
    try {
        readResultsTable(path);
    } catch (const InputError& error) {
        return std::string(error.what()).substr(path.string().size());
    }
    return "";
}

TEST_F(CsvFile, ATableOfAnotherVersionIsReadByName) {
    write("new_one,status,setting,method,frame,scene,rmse\nx,ok,pcf-1,pcf,2,fence,0.5\n");
    const ResultsTable table = readResultsTable(path);
    ASSERT_EQ(table.rows.size(), 1u);
    EXPECT_EQ(table.rows[0].scene, "fence");
    EXPECT_EQ(table.rows[0].frame, 2);
    EXPECT_EQ(table.rows[0].metrics.rmse, 0.5);
    EXPECT_EQ(table.lines, (std::vector<std::size_t>{2}));
    EXPECT_EQ(table.unknown.at("new_one"), (std::vector<std::string>{"x"}));
    EXPECT_EQ(std::ranges::count(table.absent, "frame_ms"), 1);
    EXPECT_EQ(std::ranges::count(table.absent, "rmse"), 0);
}

TEST_F(CsvFile, ATableTrustsNothing) {
    const std::string good = csvHeader() + "\n" + toCsv(fullRow()) + "\n";
    write(good);
    EXPECT_EQ(errorOfTable(path), "");
    for (const std::size_t cut : {good.size() - 1, good.size() - 20, csvHeader().size() + 5}) {
        write(good.substr(0, cut));
        EXPECT_EQ(errorOfTable(path), ":2: the file is cut short within this line") << cut;
    }
    write("");
    EXPECT_EQ(errorOfTable(path), ":1: no header line");
    write(good + toCsv(fullRow()) + "\n");
    EXPECT_EQ(errorOfTable(path),
              ":3: scene two_layers frame 3 setting pcf-0a1b2c3d has a row in line 2 already");
    write("scene,frame,method,setting\na,0,b,c\n");
    EXPECT_TRUE(errorOfTable(path).starts_with(":1: column status is missing"));
    write("rmse,rmse\n");
    EXPECT_EQ(errorOfTable(path), ":1: column rmse occurs 2 times");

    const auto edited = [&](const std::string& was, const std::string& is) {
        std::string line = toCsv(fullRow());
        line.replace(line.find(was), was.size(), is);
        write(csvHeader() + "\n" + line + "\n");
        return errorOfTable(path);
    };
    EXPECT_EQ(edited(",ok,", ",fine,"),
              ":2: column status: 'fine'; valid are ok, failed, unsupported");
    EXPECT_EQ(edited(",0.01,", ",nan,"), ":2: column rmse: 'nan' is not finite");
    EXPECT_EQ(edited(",0.01,", ",inf,"), ":2: column rmse: 'inf' is not finite");
    EXPECT_EQ(edited(",0.01,", ",-0.01,"), ":2: column rmse: '-0.01' is below 0");
    EXPECT_EQ(edited(",0.01,", ",fast,"), ":2: column rmse: 'fast' is not a number");
    EXPECT_EQ(edited(",0.01,", ","), ":2: 52 fields, expected 53");
}

TEST_F(CsvFile, ACheckedReadingRefusesWhatNoRunWrites) {
    const auto refused = [&](const std::string& was, const std::string& is) -> std::string {
        std::string line = toCsv(fullRow());
        line.replace(line.find(was), was.size(), is);
        write(csvHeader() + "\n" + line + "\n");
        try {
            readCheckedCsv(path);
        } catch (const InputError& error) {
            return std::string(error.what()).substr(path.string().size());
        }
        return "";
    };
    EXPECT_EQ(refused(",0.01,", ",0.01,"), "");
    EXPECT_EQ(refused(",ok,", ",fine,"), "");
    EXPECT_EQ(refused(",0.01,", ",nan,"), ":2: column rmse: 'nan' is not finite");
    EXPECT_EQ(refused(",0.01,", ",-0.01,"), ":2: column rmse: '-0.01' is below 0");
    for (const std::string name : {"..", "../two_layers", "/etc/passwd", ""}) {
        EXPECT_EQ(refused("two_layers,", name + ","),
                  ":2: column scene: '" + name + "' is no name");
        EXPECT_EQ(refused(",pcf-0a1b2c3d,", "," + name + ","),
                  ":2: column setting: '" + name + "' is no name");
    }
    write(csvHeader() + "\n" + toCsv(fullRow()) + "\ncut");
    EXPECT_EQ(readCheckedCsv(path).size(), 1u);
    write(csvHeader() + "\n" + toCsv(fullRow()) + "\n" + toCsv(fullRow()) + "\n");
    EXPECT_THROW(readCheckedCsv(path), InputError) << "two rows of one cell";
}

TEST(NumberInColumn, GivesWhatTheCsvHas) {
    Row row = fullRow();
    EXPECT_EQ(numberInColumn(row, "frame_ms"), 0.1);
    EXPECT_EQ(numberInColumn(row, "repeats"), 9.0);
    EXPECT_EQ(numberInColumn(failedRow(), "repeats"), std::nullopt) << "an empty field";
    row.metrics.flip.reset();
    EXPECT_EQ(numberInColumn(row, "flip"), std::nullopt);
    EXPECT_THROW(numberInColumn(row, "scene"), std::invalid_argument) << "text";
    EXPECT_THROW(numberInColumn(row, "no_such"), std::invalid_argument);
}

}  // namespace
}  // namespace penumbra
