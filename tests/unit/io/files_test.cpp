#include "io/files.hpp"

#include "io/series_names.hpp"
#include "skein/core/error.hpp"

#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>

namespace fs = std::filesystem;

namespace skein {
namespace {

struct FilesTest : testing::Test {
    std::string directory;

    void SetUp() override {
        std::string pattern = (fs::temp_directory_path() / "skein_test_XXXXXX").string();
        ASSERT_TRUE(::mkdtemp(pattern.data()));
        directory = pattern;
    }
    void TearDown() override { fs::remove_all(directory); }
    std::string path(const std::string& name) const { return directory + "/" + name; }
    /// Message of the IoError that a deed ends in.
    template <class Deed> static std::string error_of(Deed deed) {
        try {
            deed();
        } catch (const IoError& error) {
            return error.what();
        }
        return "no error";
    }
};

TEST_F(FilesTest, text_comes_back_as_written_and_no_other_file_stays) {
    write_file(path("a.txt"), "first");
    write_file(path("a.txt"), std::string("second\0line\n", 12));
    EXPECT_EQ(read_file(path("a.txt")), std::string("second\0line\n", 12));
    EXPECT_EQ(std::distance(fs::directory_iterator(directory), fs::directory_iterator()), 1);
}

TEST_F(FilesTest, errors_name_path_and_reason) {
    EXPECT_EQ(error_of([&] { read_file(path("absent")); }),
              path("absent") + ": cannot be opened (No such file or directory)");
    EXPECT_EQ(error_of([&] { write_file(path("absent/a"), "x"); }),
              path("absent") + ": cannot be inspected (No such file or directory)");
    fs::create_directory(path("folder"));
    const auto text = error_of([&] { write_file(path("folder"), "x"); });
    EXPECT_NE(text.find("cannot be renamed"), text.npos) << text;
    EXPECT_FALSE(fs::exists(path("folder.tmp")));
}

TEST_F(FilesTest, full_device_is_an_error) {
    const auto text = error_of([&] {
        fs::create_symlink("/dev/full", path("full.tmp"));
        write_file(path("full"), "x");
    });
    EXPECT_NE(text.find("cannot be written (No space left on device)"), text.npos) << text;
}

TEST_F(FilesTest, series_has_exact_numbers) {
    SeriesFile series(path("s.csv"), {"energy[J]", "tip[m]"}, -1);
    series.append(0, 0, std::vector<double>{0.1, -1e-300});
    series.append(5, 1.0 / 3, std::vector<double>{1e22, 3});
    EXPECT_EQ(read_file(path("s.csv")), "step,time[s],energy[J],tip[m]\n"
                                        "0,0,0.10000000000000001,-1e-300\n"
                                        "5,0.33333333333333331,1e+22,3\n");
}

TEST_F(FilesTest, series_resumes_at_a_step_without_gap_or_repetition) {
    {
        SeriesFile series(path("s.csv"), {"a"}, -1);
        for (const int step : {0, 10, 20, 30}) series.append(step, 0.5 * step, std::vector<double>{1});
    }
    SeriesFile series(path("s.csv"), {"a"}, 20);
    series.append(20, 10, std::vector<double>{2});
    series.append(30, 15, std::vector<double>{2});
    EXPECT_EQ(read_file(path("s.csv")), "step,time[s],a\n0,0,1\n10,5,1\n20,10,1\n30,15,2\n");
    SeriesFile(path("s.csv"), {"a"}, -1);
    EXPECT_EQ(read_file(path("s.csv")), "step,time[s],a\n");
}

TEST_F(FilesTest, series_drops_a_row_that_a_killed_run_left_unfinished) {
    for (const std::string unfinished : {"1", "15,7.5", "15,7.5,3.25"}) {
        write_file(path("s.csv"), "step,time[s],a,b\n10,5,1,2\n" + unfinished);
        SeriesFile(path("s.csv"), {"a", "b"}, 20);
        EXPECT_EQ(read_file(path("s.csv")), "step,time[s],a,b\n10,5,1,2\n");
    }
}

TEST_F(FilesTest, series_keeps_rows_of_a_killed_run) {
    if (const auto child = ::fork(); child == 0) {
        auto* series = new SeriesFile(path("s.csv"), {"a"}, -1);
        series->append(10, 5, std::vector<double>{1});
        series->flush();
        series->append(20, 10, std::vector<double>{2});
        ::_exit(0);
    } else {
        ::waitpid(child, nullptr, 0);
    }
    EXPECT_EQ(read_file(path("s.csv")), "step,time[s],a\n10,5,1\n20,10,2\n");
    SeriesFile series(path("s.csv"), {"a"}, 10);
    series.append(10, 5, std::vector<double>{3});
    series.append(20, 10, std::vector<double>{3});
    EXPECT_EQ(read_file(path("s.csv")), "step,time[s],a\n10,5,1\n20,10,3\n");
}

TEST_F(FilesTest, series_keeps_rows_that_are_computed_again) {
    for (const int last : {30, 40}) {
        {
            SeriesFile series(path("s.csv"), {"a"}, last == 30 ? -1 : 20);
            for (int step = 0; step <= last; step += 10) series.append(step, step, std::vector<double>{1.0 * last});
        }
        write_file(path("s.csv"), read_file(path("s.csv")) + "50,5"); // killed in the middle of a row
        SeriesFile(path("s.csv"), {"a"}, 20);
        EXPECT_EQ(read_file(path("s.csv")), "step,time[s],a\n0,0,30\n10,10,30\n20,20,30\n");
    }
    EXPECT_EQ(read_file(path("s.lost.csv")), "step,time[s],a\n30,30,30\n50,5\n30,30,40\n40,40,40\n50,5\n");
}

TEST_F(FilesTest, series_that_is_not_what_its_mark_says_is_put_aside) {
    std::string told;
    const auto warn = [&](const std::string& text) { told += text; };
    const auto written = [&] {
        SeriesFile series(path("s.csv"), {"a"}, -1);
        for (const int step : {0, 10}) series.append(step, step, std::vector<double>{1});
        const SeriesMark mark = series.mark();
        series.append(20, 20, std::vector<double>{1});
        return mark;
    };
    SeriesMark mark = written();
    const std::string whole = read_file(path("s.csv")), head = "step,time[s],a\n", good = head + "0,0,1\n10,10,1\n";
    { SeriesFile(path("s.csv"), {"a"}, 10, &mark, warn); }
    EXPECT_EQ(read_file(path("s.csv")), good);
    EXPECT_EQ(told, "");

    for (std::size_t at = 0; at < good.size(); ++at) { // any byte
        std::string changed = whole;
        changed[at] ^= 1;
        write_file(path("s.csv"), changed);
        { SeriesFile(path("s.csv"), {"a"}, 10, &mark, warn); }
        EXPECT_NE(told.find("its rows were changed"), told.npos) << at;
        EXPECT_EQ(read_file(path("s.csv")), head);
        EXPECT_EQ(read_file(path("s.csv.damaged")), changed);
        fs::remove(path("s.csv.damaged"));
        told.clear();
    }
    write_file(path("s.csv"), good.substr(0, good.size() - 8));
    { SeriesFile(path("s.csv"), {"a"}, 10, &mark, warn); }
    EXPECT_NE(told.find("it has 21 bytes of 29"), told.npos) << told;
    fs::remove(path("s.csv"));
    told.clear();
    { SeriesFile(path("s.csv"), {"a"}, 10, &mark, warn); }
    EXPECT_NE(told.find("it is missing"), told.npos) << told;
}

TEST_F(FilesTest, series_row_that_could_not_be_written_comes_from_the_mark) {
    SeriesMark mark;
    {
        SeriesFile series(path("s.csv"), {"a"}, -1);
        series.append(0, 0, std::vector<double>{1});
        mark = series.mark();
        mark.row = "10,10,1\n"; // half of it is in the file
        write_file(path("s.csv"), read_file(path("s.csv")) + "10,1");
    }
    SeriesFile series(path("s.csv"), {"a"}, 10, &mark);
    series.append(10, 10, std::vector<double>{2});
    series.append(20, 20, std::vector<double>{2});
    EXPECT_EQ(read_file(path("s.csv")), "step,time[s],a\n0,0,1\n10,10,1\n20,20,2\n");
    EXPECT_EQ(series.mark().digest, text_digest(read_file(path("s.csv"))));
}

TEST_F(FilesTest, what_is_under_a_temporary_name_stays) {
    write_file(path("a.txt.tmp"), "of another program");
    write_file(path("a.txt"), "own");
    EXPECT_EQ(read_file(path("a.txt.tmp")), "of another program");
    EXPECT_EQ(read_file(path("a.txt")), "own");
}

TEST_F(FilesTest, a_lock_that_is_none_stays) {
    write_file(path(".lock"), "of another program");
    EXPECT_NE(error_of([&] { DirectoryLock lock(directory); }).find("is not the lock of a run"), std::string::npos);
    EXPECT_EQ(read_file(path(".lock")), "of another program");
}

TEST_F(FilesTest, series_of_other_columns_is_not_overwritten) {
    write_file(path("s.csv"), "step,time[s],a\n10,5,1\n");
    const auto text = error_of([&] { SeriesFile(path("s.csv"), {"b"}, 20); });
    EXPECT_NE(text.find("its columns are not those of this run"), text.npos) << text;
    EXPECT_EQ(read_file(path("s.csv")), "step,time[s],a\n10,5,1\n");
}

TEST(SeriesNames, headers_of_the_format_before_differ_in_renamed_columns_alone) {
    EXPECT_EQ(earlier_header("step,time[s],contact_energy[J],contact_friction_work[J],contact_viscous_work[J],max_"
                             "overlap[-],rebuilds[-],"
                             "wall_friction_work[J],wall_viscous_work[J],max_speed[m/s]\n"),
              "step,time[s],contact_energy[J],contact_rubbed[J],contact_damped[J],deepest_overlap[-],renewals[-],wall_"
              "rubbed[J],"
              "wall_damped[J],max_speed[m/s]\n");
    for (const std::string same : {"", "\n", "a", "a,b\n", "max_overlap[-] of the lid,rebuilds\n"})
        EXPECT_EQ(earlier_header(same), same);
}

struct EarlierSeries : FilesTest {
    static constexpr const char* columns = "contact_friction_work[J]";
    const std::string earlier = "step,time[s],contact_rubbed[J]\n", now = "step,time[s],contact_friction_work[J]\n",
                      rows = "0,0,1\n10,10,1\n", later = "20,20,1\n";
    std::string told;

    SeriesMark mark_of(const std::string& content) const { return {content.size(), text_digest(content), {}}; }
    /// Resumes at step 10, writes a row; the file as it is then.
    std::string resumed(const SeriesMark* mark) {
        SeriesFile series(path("s.csv"), {columns}, 10, mark, [&](const std::string& text) { told += text; });
        series.append(20, 20, std::vector<double>{2});
        EXPECT_EQ(series.mark().digest, text_digest(read_file(path("s.csv"))));
        return read_file(path("s.csv"));
    }
};

TEST_F(EarlierSeries, goes_on_with_the_names_of_today) {
    const SeriesMark of_earlier = mark_of(earlier + rows), of_now = mark_of(now + rows);
    const struct {
        std::string head;
        const SeriesMark* mark;
    } cases[] = {{earlier, nullptr},
                 {earlier, &of_earlier},
                 {now, &of_earlier},
                 {now, &of_now}}; // the third: killed after renaming
    for (const auto& [head, mark] : cases) {
        fs::remove(path("s.lost.csv"));
        write_file(path("s.csv"), head + rows + later);
        EXPECT_EQ(resumed(mark), now + rows + "20,20,2\n");
        EXPECT_EQ(read_file(path("s.lost.csv")), now + later);
        EXPECT_EQ(told, "");
    }
}

TEST_F(EarlierSeries, rows_lost_before_get_the_names_of_today) {
    write_file(path("s.lost.csv"), earlier + "20,20,0\n");
    write_file(path("s.csv"), earlier + rows + later);
    resumed(nullptr);
    EXPECT_EQ(read_file(path("s.lost.csv")), now + "20,20,0\n" + later);
}

TEST_F(EarlierSeries, row_that_could_not_be_written_comes_from_the_mark) {
    SeriesMark mark = mark_of(earlier + "0,0,1\n");
    mark.row = "10,10,1\n";
    write_file(path("s.csv"), earlier + "0,0,1\n10,1");
    EXPECT_EQ(resumed(&mark), now + rows + "20,20,2\n");
}

TEST_F(EarlierSeries, changed_rows_are_noticed_under_either_header) {
    const SeriesMark mark = mark_of(earlier + rows);
    for (const std::string& head : {earlier, now}) {
        write_file(path("s.csv"), head + "0,0,1\n10,10,3\n");
        EXPECT_EQ(resumed(&mark), now + "20,20,2\n");
        EXPECT_NE(told.find("its rows were changed"), told.npos) << told;
        EXPECT_EQ(read_file(path("s.csv.damaged")), head + "0,0,1\n10,10,3\n");
        fs::remove(path("s.csv.damaged"));
        told.clear();
    }
}

TEST_F(EarlierSeries, of_other_columns_is_not_overwritten) {
    write_file(path("s.csv"), "step,time[s],contact_rubbed\n10,5,1\n");
    EXPECT_NE(error_of([&] { SeriesFile(path("s.csv"), {columns}, 20); }).find("its columns are not those of this run"),
              std::string::npos);
}

TEST_F(FilesTest, directory_is_locked_for_one_run_at_a_time) {
    auto lock = std::make_unique<DirectoryLock>(directory);
    const auto text = error_of([&] { DirectoryLock second(directory); });
    EXPECT_EQ(text.find(directory + ": in use by another run (process " + std::to_string(::getpid()) + " on "), 0u)
        << text;
    lock.reset();
    EXPECT_NO_THROW(DirectoryLock{directory});
}

TEST_F(FilesTest, lock_ends_with_its_process) {
    if (const auto child = ::fork(); child == 0) {
        new DirectoryLock(directory); // never deleted: a killed process does not clean up
        ::_exit(0);
    } else {
        ::waitpid(child, nullptr, 0);
    }
    EXPECT_NO_THROW(DirectoryLock{directory});
}

} // namespace
} // namespace skein
