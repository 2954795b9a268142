#include "attachments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-braces"  // which deal.II's flags ask for
#include "../common/study.hpp"
#pragma GCC diagnostic pop

namespace muscle {

using common::Error;

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// Times that differ by rounding only.
bool same_time(double a, double b) { return std::abs(a - b) <= 1e-10 * std::max(std::abs(a), std::abs(b)); }

std::vector<std::string> words_of_item(const std::string& item) {
  std::istringstream in(item);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

}  // namespace

double TimeTable::at(double time, double part) const {
  std::size_t k = 0;  // the last row that is not after `time`
  while (k + 1 < rows_.size() && (rows_[k + 1].first <= time || same_time(rows_[k + 1].first, time))) ++k;
  if (same_time(rows_[k].first, time)) {
    std::size_t first = k;
    while (first > 0 && same_time(rows_[first - 1].first, time)) --first;
    const double before = rows_[first].second, after = rows_[k].second;
    return before + part * (after - before);
  }
  if (k + 1 == rows_.size()) return rows_[k].second;
  const auto &a = rows_[k], &b = rows_[k + 1];
  return a.second + (b.second - a.second) * (time - a.first) / (b.first - a.first);
}

bool TimeTable::jumps_at(double time) const { return at(time, 0) != at(time, 1); }

double TimeTable::next_row(double time) const {
  for (const auto& row : rows_) {
    if (row.first > time && !same_time(row.first, time)) return row.first;
  }
  return never;
}

double TimeTable::changing_for(double time) const {
  const double next = next_row(time);
  if (!(next < never) || at(next, 0) == at(time, 1)) return never;
  double last = 0;
  for (const auto& row : rows_) {
    if (row.first <= time || same_time(row.first, time)) last = row.first;
  }
  return next - last;
}

TimeTable read_table(const std::vector<std::string>& rows, const std::string& name, const std::string& place,
                     const std::function<void(const std::string&)>& fail) {
  std::vector<std::pair<double, double>> table;
  for (const std::string& row : rows) {
    const std::size_t colon = row.find(':');
    double time, factor;
    if (colon == std::string::npos || !common::to_number(row.substr(0, colon), time) ||
        !common::to_number(row.substr(colon + 1), factor) || !(time >= 0))
      fail("expected TIME:" + name + place + ", found '" + common::visible(row) + "'");
    if (table.empty() && time > 0) table.emplace_back(0, 0);
    if (!table.empty() && time < table.back().first)
      fail("the times" + place + " must ascend; " + common::text_of(time) + " does not");
    table.emplace_back(time, factor);
  }
  if (table.empty()) fail("expected TIME:" + name + place);
  return TimeTable(table);
}

std::vector<Action> read_actions(const std::string& text, const TimeTable& ramp) {
  std::vector<Action> actions;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ';');) {
    std::vector<std::string> words = words_of_item(item);
    if (words.empty()) continue;
    const auto fail = [&](const std::string& why) {
      throw Error("Attachments/List: '" + common::visible(item) + "': " + why);
    };
    Action action;
    action.surface = words[0];
    action.table = ramp;
    const auto at = std::find(words.begin(), words.end(), "at");
    if (at != words.end()) {
      action.table = read_table({at + 1, words.end()}, "FACTOR", " after 'at'", fail);
      action.own_table = true;
      words.erase(at, words.end());
    }
    const std::string kind = words.size() > 1 ? words[1] : "";
    const bool away = words.size() > 2 && kind == "slides" && words[2] == "away";
    std::vector<double> x;
    for (std::size_t i = away ? 3 : 2; i < words.size(); ++i) {
      double value = 0;
      if (!common::to_number(words[i], value))
        fail("expected a number, found '" + common::visible(words[i]) + "'" + common::hint(words[i]));
      x.push_back(value);
    }
    const auto need = [&](std::size_t n, const std::string& what) {
      if (x.size() != n) fail(n > 0 ? "expected " + what + " after '" + kind + "'" : "expected no numbers");
    };
    const auto vector = [&](std::size_t i) { return dealii::Tensor<1, 3>({x[i], x[i + 1], x[i + 2]}); };
    if (kind == "fixed") {
      need(0, "");
      action.kind = Action::fixed;
    } else if (kind == "displaced") {
      need(3, "a vector of three numbers");
      action.kind = Action::displaced;
      action.vector = vector(0);
    } else if (kind == "away") {
      need(1, "a part of the distance");
      action.kind = Action::away;
      action.amount = x[0];
    } else if (kind == "turned") {
      need(7, "a point of the axis, its direction and the angle in degrees, seven numbers,");
      action.kind = Action::turned;
      action.point = dealii::Point<3>(vector(0));
      action.axis = vector(3);
      if (!(action.axis.norm() > 0)) fail("the axis must have a length > 0");
      action.axis /= action.axis.norm();
      action.amount = x[6] * std::acos(-1.0) / 180;
    } else if (kind == "slides") {
      need(1, away ? "a part of the distance" : "a distance along its outward normal");
      action.kind = away ? Action::slides_away : Action::slides;
      action.amount = x[0];
    } else if (kind == "pulled") {
      need(3, "a force of three numbers");
      action.kind = Action::pulled;
      action.vector = vector(0);
    } else if (kind == "pressed") {
      need(1, "a force along its outward normals");
      action.kind = Action::pressed;
      action.amount = x[0];
    } else {
      fail("expected NAME and one of fixed, displaced, away, turned, slides, pulled, pressed" +
           (kind.empty() ? std::string() : ", found '" + common::visible(kind) + "'"));
    }
    for (const Action& other : actions) {
      if (other.surface == action.surface) fail("there is an action for " + action.surface + " already");
    }
    actions.push_back(action);
  }
  return actions;
}

TimeTable read_protocol(const std::string& path, double cycle, double end) {
  const study::Study protocol = study::Reader::read(path);
  if (!protocol.tendon_place.empty())
    throw Error(protocol.tendon_place + ": a tendon in series: must be a section of the mesh here");
  const double length = protocol.knots.back().time;
  if (cycle > 0 && length > cycle * (1 + 1e-12))
    throw Error("Attachments/Cycle = " + common::text_of(cycle) + ": must be at least the length of " + path +
                ", " + common::text_of(length));
  if (cycle > 0 && end / cycle * static_cast<double>(protocol.knots.size()) > 1e6)
    throw Error("Attachments/Cycle = " + common::text_of(cycle) +
                ": must be longer: more than a million rows to the end, which is at " + common::text_of(end));
  std::vector<std::pair<double, double>> rows;
  for (double start = 0; start < end * (1 - 1e-12) || start == 0; start += cycle) {
    for (const study::Knot& knot : protocol.knots) {
      // A cycle begins with what the one before has left, not at stretch 1.
      if (start > 0 && knot.time == 0 && &knot == protocol.knots.data()) continue;
      if (start > 0 && !rows.empty() && rows.back().first < start)
        rows.emplace_back(start, rows.back().second);
      rows.emplace_back(start + knot.time, knot.stretch - 1);
    }
    if (!(cycle > 0)) break;
  }
  return TimeTable(rows);
}

const std::vector<FacetPoint>& facet_points(unsigned n_nodes) {
  static const auto make = [](unsigned n) {
    std::vector<FacetPoint> points;
    if (n == 4) {
      static constexpr int corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
      const double g = 1 / std::sqrt(3.0);
      for (const auto& at : corner) {
        FacetPoint p{};
        p.weight = 1;
        for (int a = 0; a < 4; ++a) {
          const double x = (1 + g * at[0] * corner[a][0]) / 2, y = (1 + g * at[1] * corner[a][1]) / 2;
          p.N[a] = x * y;
          p.d1[a] = corner[a][0] * y / 2;
          p.d2[a] = x * corner[a][1] / 2;
        }
        points.push_back(p);
      }
      return points;
    }
    // Exact to fourth order: six points (Dunavant 1985).
    constexpr double a1 = 0.445948490915965, w1 = 0.223381589678011, a2 = 0.091576213509771,
                     w2 = 0.109951743655322;
    for (int q = 0; q < 6; ++q) {
      const double a = q < 3 ? a1 : a2;
      double L[3] = {a, a, a};
      L[q % 3] = 1 - 2 * a;
      FacetPoint p{};
      p.weight = (q < 3 ? w1 : w2) / 2;
      static constexpr double slope[3][2] = {{-1, -1}, {1, 0}, {0, 1}};
      for (int k = 0; k < 3; ++k) {
        const int m = (k + 1) % 3;
        p.N[k] = n == 3 ? L[k] : L[k] * (2 * L[k] - 1);
        const double f = n == 3 ? 1 : 4 * L[k] - 1;
        p.d1[k] = f * slope[k][0];
        p.d2[k] = f * slope[k][1];
        if (n == 3) continue;
        p.N[3 + k] = 4 * L[k] * L[m];
        p.d1[3 + k] = 4 * (slope[k][0] * L[m] + L[k] * slope[m][0]);
        p.d2[3 + k] = 4 * (slope[k][1] * L[m] + L[k] * slope[m][1]);
      }
      points.push_back(p);
    }
    return points;
  };
  static const std::vector<FacetPoint> triangle = make(3), square = make(4), triangle6 = make(6);
  return n_nodes == 3 ? triangle : n_nodes == 4 ? square : triangle6;
}

}  // namespace muscle
