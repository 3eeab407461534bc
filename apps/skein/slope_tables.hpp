// Slopes along a path as skein path --by writes and prints them: slopes.csv of its points, critical_slopes.csv of its
// limit and branch points.
#pragma once

#include "equilibrium/path.hpp"
#include "studies/path_slopes.hpp"

#include <nlohmann/json.hpp>

#include <string>

namespace skein {

class SlopeTables {
public:
    /// `names`: of what is asked for; `along`: the path's number, and `unit` its unit.
    SlopeTables(PathSlopes slopes, const GradientReport& names, const std::string& along, const std::string& unit);
    /// Goes on below the rows of a path of so many points that was cut off, with its critical().
    void go_on(const std::string& directory, std::size_t points, nlohmann::ordered_json critical);
    /// Finds the slopes at the last point of a path, whose number in the table of points is given.
    void add(PathFollower& path, const PathPoint& point, std::size_t number, int branch);
    void write(const std::string& directory) const;
    /// Rows of limit and branch points.
    const nlohmann::ordered_json& critical() const { return critical_; }
    /// The same as text; empty where there are none.
    std::string to_text() const;

private:
    std::string critical_csv() const;

    PathSlopes slopes_;
    std::string along_, unit_, text_;
    std::vector<std::string> keys_, units_; ///< of the numbers
    nlohmann::ordered_json critical_ = nlohmann::ordered_json::array();
};

} // namespace skein
