// A value of a JSON file that knows where it stands, so that what is missing or misshapen is named.
#pragma once

#include "skein/core/error.hpp"
#include "skein/core/vec3.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace skein::replay {

/// Physics that a file asks for and this program does not have; the message names it.
struct NotBuilt : std::runtime_error {
    using std::runtime_error::runtime_error;
};
inline constexpr int exit_differs = 1, exit_not_built = 7;

class Entry {
public:
    using Json = nlohmann::json;
    Entry(const Json& value, std::string path) : json_(&value), path_(std::move(path)) {}

    const std::string& path() const { return path_; }
    const Json& json() const { return *json_; }
    bool has(const std::string& key) const {
        return json_->is_object() && json_->contains(key) && !(*json_)[key].is_null();
    }
    Entry operator[](const std::string& key) const {
        if (!has(key)) fail("has no '" + key + "'");
        return {(*json_)[key], path_ + "." + key};
    }
    std::vector<Entry> list() const {
        if (!json_->is_array()) fail("is not a list");
        std::vector<Entry> entries;
        for (const Json& value : *json_)
            entries.emplace_back(value, path_ + "[" + std::to_string(entries.size()) + "]");
        return entries;
    }

    double number() const {
        if (!json_->is_number()) fail("is not a number");
        return json_->get<double>();
    }
    double positive() const {
        const double value = number();
        if (!(value > 0)) fail("is not positive");
        return value;
    }
    long integer() const {
        if (!json_->is_number_integer()) fail("is not a whole number");
        return json_->get<long>();
    }
    /// A place in a list of `size`; -1 is the last.
    int index(int size) const {
        const long i = integer();
        if (i < -size || i >= size) fail("is outside [0, " + std::to_string(size) + ")");
        return static_cast<int>(i < 0 ? i + size : i);
    }
    std::string text() const {
        if (!json_->is_string()) fail("is not a text");
        return json_->get<std::string>();
    }
    Vec3d vector() const {
        const auto c = list();
        if (c.size() != 3) fail("does not have 3 components");
        return {c[0].number(), c[1].number(), c[2].number()};
    }
    /// Three flags, as 0 and 1 or false and true.
    Vec3d flags() const {
        const auto flag = [](const Entry& e) {
            return e.json_->is_boolean() ? double(e.json_->get<bool>()) : e.number();
        };
        const auto c = list();
        if (c.size() != 3) fail("does not have 3 components");
        return {flag(c[0]), flag(c[1]), flag(c[2])};
    }
    /// A number, or a list of one.
    double scalar() const { return json_->is_array() && json_->size() == 1 ? list().front().number() : number(); }
    double positive_scalar() const {
        const double value = scalar();
        if (!(value > 0)) fail("is not positive");
        return value;
    }
    Mat3d matrix() const {
        const auto row = list();
        if (row.size() != 3) fail("does not have 3 rows");
        return {row[0].vector(), row[1].vector(), row[2].vector()};
    }
    std::vector<double> numbers(std::size_t size) const { return items<double>(size, &Entry::number); }
    std::vector<double> positives(std::size_t size) const { return items<double>(size, &Entry::positive); }
    std::vector<Vec3d> vectors(std::size_t size) const { return items<Vec3d>(size, &Entry::vector); }
    std::vector<Mat3d> matrices(std::size_t size) const { return items<Mat3d>(size, &Entry::matrix); }

    /// A value under any other key would be physics that is passed over; texts are remarks.
    void expect_keys(std::initializer_list<std::string_view> known) const {
        for (const auto& [key, value] : json_->items())
            if (!value.is_string() && std::find(known.begin(), known.end(), key) == known.end())
                fail("has an unknown key '" + key + "'");
    }

    [[noreturn]] void fail(const std::string& what) const { throw InputError(path_ + " " + what); }

private:
    template <class T> std::vector<T> items(std::size_t size, T (Entry::*read)() const) const {
        const auto entries = list();
        if (entries.size() != size)
            fail("has " + std::to_string(entries.size()) + " entries, not " + std::to_string(size));
        std::vector<T> values;
        for (const Entry& e : entries) values.push_back((e.*read)());
        return values;
    }

    const Json* json_;
    std::string path_;
};

} // namespace skein::replay
