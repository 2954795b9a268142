#include "parameters.hpp"

#include <deal.II/base/parameter_handler.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <sstream>

#include "../common/rows.hpp"

namespace muscle {
namespace {

using dealii::ParameterHandler;
namespace Patterns = dealii::Patterns;
namespace abi = myogrowth::abi;

const double any = std::numeric_limits<double>::max(), tiny = std::numeric_limits<double>::min();

/// An entry, and what the user has said of it.
struct Entry {
  std::string section, name, allowed;
  std::unique_ptr<Patterns::PatternBase> pattern;
  std::string place;      ///< FILE:LINE:COLUMN; empty where no file says it
  bool argument = false;  ///< whether an argument says it, in the place of the file

  std::string full_name() const { return section + "/" + name; }
};

/// Every number of a list in its shortest form, so that 1 and 1.0 are the same; other texts as they are.
std::string canonical(const std::string& value) {
  std::string text;
  for (const std::string& item : dealii::Utilities::split_string_list(value)) {
    double x;
    if (!common::to_number(item, x)) return value;
    char shortest[40];
    text += (text.empty() ? "" : ", ") + std::string(shortest, std::to_chars(shortest, shortest + 40, x).ptr);
  }
  return text;
}

/// 0 (neo-Hookean), 1 (Roehrle), ...
std::string elastic_laws() {
  std::string text = "0 (neo-Hookean)";
  for (int law = 1; law <= abi::n_laws; ++law)
    text += (law < abi::n_laws ? ", " : " or ") + std::to_string(law) + " (" +
            abi::parameters_of(static_cast<abi::Law>(law)).name + ")";
  return text;
}

/// Whether a law has an active force: not law 0, and not tendon by law 2.
bool may_be_active(const abi::LawChoice& law) {
  return law.law != abi::Law::neo_hookean && !(law.law == abi::Law::blemker && abi::blemker_of(law.p).tendon);
}

bool is_active(const TimeTable& activation) {
  const auto& rows = activation.rows();
  return std::any_of(rows.begin(), rows.end(), [](const auto& row) { return row.second != 0; });
}

/// An activation: a number from 0 to 1, at once at time 0, or a table TIME:ACTIVATION, parted by blanks or
/// commas. `fail` throws with the reason.
TimeTable read_activation(const std::string& text, const std::function<void(const std::string&)>& fail) {
  std::string parted = text;
  std::replace(parted.begin(), parted.end(), ',', ' ');
  std::istringstream in(parted);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  const bool is_table = text.find(':') != std::string::npos;
  double number = 0;
  if (!is_table && !common::to_number(text, number))
    fail("must be a number >= 0 and <= 1 or a table TIME:ACTIVATION TIME:ACTIVATION ..." +
         common::hint(text));
  auto rows = is_table ? read_table(words, "ACTIVATION", "", fail).rows()
                       : std::vector<std::pair<double, double>>{{0, 0}, {0, number}};
  if (rows[0].second != 0) rows.insert(rows.begin(), {0, 0});  // it begins with a jump
  for (auto& row : rows) {
    abi::LawChoice taken{};
    if (!abi::take_activation(row.second, taken))
      fail("activation, must be >= 0 and <= 1; " + common::text_of(row.second) + " is not");
    row.second = taken.activation;
  }
  return TimeTable(rows);
}

/// All entries: declared here, set by files and arguments.
class Entries {
 public:
  Entries() { declare(); }

  /// Sets an entry: once at a place FILE:LINE:COLUMN, and once by an argument, which has none. Throws Error.
  void set(const std::string& section, const std::string& name, const std::string& value,
           const std::string& place) {
    const std::string where = place.empty() ? "" : place + ": ";
    const auto found = std::find_if(all_.begin(), all_.end(),
                                    [&](const Entry& e) { return e.section == section && e.name == name; });
    if (found == all_.end()) {
      std::string names;
      for (const Entry& e : all_) {
        if (e.section == section) names += (names.empty() ? "" : ", ") + e.name;
      }
      throw Error(where + "there is no entry '" + common::visible(section + "/" + name) +
                  (names.empty() ? "'; --entries or --help lists all" : "'; there are " + names));
    }
    if (place.empty() ? found->argument : !found->place.empty())
      throw Error(where + found->full_name() + " is said twice, with the values " +
                  common::visible(text(*found)) + " and " + common::visible(value) +
                  (place.empty() ? "" : "; first in " + found->place));
    const bool is_list = dynamic_cast<const Patterns::List*>(found->pattern.get());
    const std::string must =
        where + found->full_name() + " = " + common::visible(value) + ": must be " + found->allowed;
    if (!found->pattern->match(value)) throw Error(must + (is_list ? "" : common::hint(value)));
    if (is_list || dynamic_cast<const Patterns::Double*>(found->pattern.get())) {
      for (const std::string& item : dealii::Utilities::split_string_list(value)) {
        double x;
        if (common::to_number(item, x) && x != 0 && std::abs(x) < tiny)
          throw Error(must + ": " + common::visible(item) + " is beyond the range of double");
      }
    }
    found->place = place;
    found->argument = place.empty();
    prm_.enter_subsection(section);
    prm_.set(name, value);
    prm_.leave_subsection();
  }

  /// Reads a file: sections with their entries, each once.
  void read(const std::string& path);

  /// Throws Error that names an entry, its place and value and what is allowed.
  void check(bool good, const std::string& full_name, const std::string& allowed) const {
    if (!good) fail(full_name, "must be " + allowed);
  }
  /// Throws Error that names an entry, its place and value and what is wrong.
  void fail(const std::string& full_name, const std::string& why) const {
    const Entry& e = entry(full_name);
    const std::string value = text(e);
    throw Error((e.place.empty() ? "" : e.place + ": ") + full_name +
                (value.empty() ? " is empty" : " = " + common::visible(value)) + ": " + why);
  }
  /// The entries of a section that a file or an argument says.
  std::vector<std::string> said(const std::string& section) const {
    std::vector<std::string> names;
    for (const Entry& e : all_) {
      if (e.section == section && (e.argument || !e.place.empty())) names.push_back(e.full_name());
    }
    return names;
  }

  std::vector<std::pair<std::string, std::string>> texts() const {
    std::vector<std::pair<std::string, std::string>> result;
    for (const Entry& e : all_) result.emplace_back(e.full_name(), canonical(text(e)));
    return result;
  }

  /// The value of an entry that nobody says.
  void set_default(const std::string& section, const std::string& name, double value) {
    prm_.enter_subsection(section);
    prm_.set(name, common::text_of(value));
    prm_.leave_subsection();
  }

  ParameterHandler& prm() { return prm_; }
  const ParameterHandler& prm() const { return prm_; }

 private:
  void declare();
  const Entry& entry(const std::string& full_name) const {
    return *std::find_if(all_.begin(), all_.end(),
                         [&](const Entry& e) { return e.full_name() == full_name; });
  }
  std::string text(const Entry& e) const { return prm_.get({e.section}, e.name); }

  /// The names of all sections.
  std::string sections() const {
    std::string names;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (i == 0 || all_[i].section != all_[i - 1].section) names += (i == 0 ? "" : ", ") + all_[i].section;
    }
    return names;
  }

  ParameterHandler prm_;
  std::vector<Entry> all_;
};

void Entries::declare() {
  std::string now;  // the section
  const auto section = [&](const std::string& name, auto entries) {
    now = name;
    prm_.enter_subsection(name);
    entries();
    prm_.leave_subsection();
  };
  const auto entry = [&](const std::string& name, const std::string& start, const Patterns::PatternBase& of,
                         const std::string& allowed, const std::string& doc) {
    prm_.declare_entry(name, start, of, doc);
    all_.push_back({now, name, allowed, of.clone(), ""});
  };
  const auto real = [&](const std::string& name, const std::string& start, double least, double most,
                        const std::string& doc) {
    std::string allowed = "a number";
    if (least > -any) allowed += least == tiny ? " > 0" : " >= " + common::text_of(least);
    if (most < any) allowed += (least > -any ? " and <= " : " <= ") + common::text_of(most);
    entry(name, start, Patterns::Double(least, most), allowed, doc);
  };
  const auto whole = [&](const std::string& name, const std::string& start, int least, int most,
                         const std::string& doc) {
    entry(name, start, Patterns::Integer(least, most),
          "a whole number from " + std::to_string(least) + " to " + std::to_string(most), doc);
  };
  const auto choice = [&](const std::string& name, const std::string& start, const std::string& of,
                          const std::string& doc) {
    entry(name, start, Patterns::Selection(of), "one of " + of, doc);
  };
  const auto list = [&](const std::string& name, const std::string& start, const Patterns::PatternBase& item,
                        const std::string& allowed, unsigned least, unsigned most, const std::string& doc) {
    entry(name, start, Patterns::List(item, least, most), allowed, doc);
  };
  const auto word = [&](const std::string& name, const std::string& start, const std::string& doc) {
    entry(name, start, Patterns::Anything(), "a text", doc);
  };

  section("Geometry", [&] {
    choice("Kind", "cylinder", "cylinder|brick|file",
           "cylinder: hexahedra, along z, cut to pi r^2 l in spite of its straight edges; brick: hexahedra; "
           "file: hexahedra and wedges as examples/calculix/cylinder_mesh.py writes them. The ends are the "
           "planes of least and largest z. Mesh/File takes the place of all this");
    real("Length", "400", tiny, any, "of cylinder and brick, along z [length]");
    real("Radius", "10", tiny, any, "of the cylinder [length]");
    real("Width", "10", tiny, any, "of the brick, along x [length]");
    real("Height", "10", tiny, any, "of the brick, along y [length]");
    whole("Layers", "16", 1, 100000, "of the cylinder's coarsest mesh, which has 5 cells a layer [-]");
    whole("Refinements", "2", 0, 8, "of the cylinder: each makes eight cells of one [-]");
    list("Cells", "4, 4, 4", Patterns::Integer(1, 10000), "three whole numbers from 1 to 10000", 3, 3,
         "of the brick along x, y, z [-]");
    word("File", "", "the mesh, if Kind = file; relative to the folder the program is started in");
  });
  section("Mesh", [&] {
    word("File", "",
         "a mesh with sections and surfaces, as ./run muscle writes it (docs/muscle.md); [length] is mm");
    choice("Degree", "as the file", "as the file|1|2",
           "of its tetrahedra: 2 puts a node into the middle of every edge, 1 drops such nodes");
  });
  section("Materials", [&] {
    word(
        "List", "",
        "what the sections of Mesh/File are made of, parted by semicolons: NAME muscle, which has the "
        "parameters of section Muscle but for NAME=VALUE that follow (law, activation and the constants of "
        "the elastic law too); or NAME tendon, which does not grow, with c1 and c2 Tendon/Stiffness times "
        "those of Muscle or as c1=VALUE c2=VALUE that follow, or with law=VALUE and its constants. A mesh of "
        "one section needs none: it is muscle");
  });
  section("Attachments", [&] {
    word("List", "",
         "what happens to surfaces of Mesh/File, parted by semicolons: NAME fixed; NAME displaced DX DY DZ; "
         "NAME away PART, displaced along the line between the attachments' centroids by this part of their "
         "distance; NAME turned PX PY PZ AX AY AZ DEGREES, about an axis through P; NAME slides D, displaced "
         "along its mean outward normal and free to contract in its plane; NAME slides away PART; NAME "
         "pulled FX FY FZ, a force that keeps its direction; NAME pressed F, a force along its outward "
         "normals as they turn [mm, mN]. 'at TIME:FACTOR TIME:FACTOR ...' may follow; else the factor grows "
         "to 1 until Time/Ramp. Empty: Proximal fixed, Distal away 0.1");
    word("Proximal", "PROXIMAL", "the surface that the line between the attachments begins at");
    word("Distal", "DISTAL", "the surface that it ends at; history.csv has the force on it along this line");
    word("Protocol", "",
         "a study's file (docs/studies.md): its stretch - 1 takes the place of PART and factor of 'away' and "
         "'slides away'; its parameters are not used");
    real("Cycle", "0", 0, any, "the protocol starts again after so long; 0: never [time]");
  });
  section("Muscle", [&] {
    const myogrowth::FibreGrowth<> paper;  // its defaults
    for (int i = 0; i < abi::n_props; ++i) {
      myogrowth::FibreGrowth<> m = paper;
      const double* start = abi::parameter(m, i);
      const abi::Property& p = abi::property(i);
      if (start)
        real(p.symbol, common::text_of(*start), -any, any,
             std::string(p.meaning) + "; " + abi::text(p.allowed) + " [" + p.unit + "]");
    }
    entry("Law", "0", Patterns::Integer(0, abi::n_laws), elastic_laws(),
          "elastic law: " + elastic_laws() +
              "; the constants of laws 1 to 3 are in the sections below, c1 and c2 are of law 0 "
              "(docs/laws.md)");
    word("Activation", "0",
         "of laws 1 to 3: a number >= 0 and <= 1, which holds from the beginning, or a table TIME:ACTIVATION "
         "TIME:ACTIVATION ..., linear between rows, from 0 at time 0; two rows of one time are a jump");
    choice("Energy", "reference", "reference|grown", "the volume that the elastic energy is counted per");
    choice("Integration", "second order", "backward Euler|second order", "of growth in time");
    choice("Volume", "pointwise", "pointwise|mean dilatation",
           "mean dilatation for nearly incompressible muscle, c1 >> c2, where pointwise locks");
  });
  for (int law = 1; law <= abi::n_laws; ++law) {
    const abi::LawParameters& table = abi::parameters_of(static_cast<abi::Law>(law));
    section(table.name, [&] {
      for (int i = 0; i < table.size; ++i) {
        const abi::Property& p = table.entry[i];
        real(p.symbol, common::text_of(p.initial), -any, any,
             "of elastic law " + std::to_string(law) + ": " + p.meaning + "; " + abi::text(p.allowed) + " [" +
                 p.unit + "]");
      }
    });
  }
  section("Tendon", [&] {
    real("Length", "0", 0, any, "of a layer at each end that does not grow; 0: none [length]");
    real("Stiffness", "100", tiny, any, "of that layer, over the muscle's [-]");
  });
  section("Fibre", [&] {
    choice("Kind", "default", "default|flow|mesh|uniform|oblique|pennate|function|file",
           "default: those of Mesh/File where it has any, else flow with Mesh/File, else uniform; flow: "
           "along the gradient of a potential that is 0 on the surface From, 1 on To and flows through no "
           "other; mesh: of Mesh/File; uniform: Direction; oblique: at Angle to z in the x-z plane; pennate: "
           "the same, inclined towards the plane x = 0 from either side; function: of the place; file: rows "
           "of x y z n1 n2 n3, the nearest row holds");
    word("From", "PROXIMAL",
         "surfaces of Mesh/File, parted by commas: an attachment, and aponeuroses that fibres come from");
    word("To", "DISTAL", "the same for where the fibres go to");
    word("List", "",
         "fibres of sections and element sets of Mesh/File, parted by semicolons, in the place of those by "
         "Kind: NAME uniform X Y Z; NAME flow FROM TO, surfaces or several, parted by commas without blanks; "
         "NAME mesh. Of an element in several sets the last one holds");
    list("Direction", "0, 0, 1", Patterns::Double(), "three numbers", 3, 3, "any length > 0");
    real("Angle", "0", -90, 90, "[degrees]");
    word("Function", "0; 0; 1", "three expressions in x, y, z, parted by semicolons; any length > 0");
    word("File", "", "relative to the folder the program is started in");
  });
  section("Ends", [&] {
    choice("Kind", "clamped", "clamped|free|mixed",
           "clamped; free to contract in their planes; mixed: the proximal end clamped, the distal one free "
           "to contract");
    real("Pull", "40", -any, any, "displacement of the distal end along z at the end of the ramp [length]");
    real("Tolerance", "0.01", tiny, 0.4,
         "nodes that are no farther from the plane of an end are of that end, over the least height of a "
         "cell along z [-]");
  });
  section("Time", [&] {
    real("Ramp", "1", tiny, any, "until when the pull grows, linearly; then it is held [time]");
    real("End", "42", tiny, any, "[time]");
    choice("Steps", "adaptive", "adaptive|fixed|listed",
           "adaptive: from Step on as long as Tolerance allows; fixed: Step each; listed: to Times");
    real("Step", "0.02", tiny, any, "the first step, or each [time]");
    real("Longest", "4", tiny, any, "no step is longer [time]");
    real("Part", "0.1", 1e-6, 1,
         "no step is a larger part of the time in which the pull, or an attachment on its way, moves [-]");
    real("Tolerance", "1e-4", tiny, 1, "of the time error of G in a step, as the library estimates it [-]");
    list("Times", "", Patterns::Double(tiny, any), "numbers > 0", 0, 1000000,
         "ends of the steps; the last one takes the place of End [time]");
  });
  section("Solver", [&] {
    real("Newton tolerance", "1e-8", 1e-14, 1e-2,
         "norm of the forces out of balance, over that of the reactions [-]");
    whole("Newton iterations", "12", 1, 1000, "more than these, and the step is cut [-]");
    choice("Preconditioner", "ML", "ML|GAMG",
           "algebraic multigrid of Trilinos or of PETSc; GMRES, preconditioned on the right");
    real("Krylov tolerance", "1e-4", 1e-14, 0.1,
         "of the first linear solve of a step, over its right side, and a hundredth of it later; no solve "
         "goes "
         "below a tenth of Newton's [-]");
    choice(
        "Set up", "when slow", "when slow|every step",
        "of the preconditioner: when slow: when it takes half as many iterations again as when it was new");
    choice(
        "Predictor", "true", "true|false",
        "a step starts from the displacements that the last three suggest: over time while attachments move, "
        "over mean G while they hold");
    choice("Assembly", "compact", "compact|dense",
           "dense: the loop one would write first, to compare with: P and dP/dF of every point, 9 x 9 "
           "products, insertion by deal.II, a tangent at every check of Newton's method; pointwise Volume "
           "and Preconditioner ML only");
  });
  section("Output", [&] {
    word("Folder", "out/mpi", "of all results; made if it is not there");
    list("Times", "1, 7, 14, 28, 42", Patterns::Double(tiny, any), "numbers > 0", 0, 10000,
         "when fields are written, beside the end; steps end there; empty: none at all [time]");
    real("Threshold", "1.05", tiny, any, "hot_spots.csv has the volume with lambda_e above this [-]");
    whole("Fascicles", "40", 0, 10000,
          "streamlines of the fibres that are traced from Attachments/Proximal [-]");
    choice("Fibres", "false", "false|true",
           "true: fibres.csv has the fibre of every integration point, in the order of the mesh file");
    whole("Checkpoint every", "20", 0, 1000000, "so many steps; 0: only on SIGTERM or SIGUSR1 [-]");
    choice("Resume", "false", "false|true|force",
           "true: go on from the checkpoint in Folder, on any number of ranks, if mesh, muscle and pull are "
           "those of its run; force: also if they are not");
  });
}

std::vector<double> numbers(const std::string& text) {
  return dealii::Utilities::string_to_double(dealii::Utilities::split_string_list(text));
}

Parameters values(ParameterHandler& prm) {
  Parameters p;
  prm.enter_subsection("Geometry");
  p.geometry.kind = prm.get("Kind");
  p.geometry.length = prm.get_double("Length");
  p.geometry.radius = prm.get_double("Radius");
  p.geometry.width = prm.get_double("Width");
  p.geometry.height = prm.get_double("Height");
  p.geometry.layers = static_cast<int>(prm.get_integer("Layers"));
  p.geometry.refinements = static_cast<int>(prm.get_integer("Refinements"));
  for (double n : numbers(prm.get("Cells"))) p.geometry.cells.push_back(static_cast<int>(n));
  p.geometry.file = prm.get("File");
  prm.leave_subsection();

  prm.enter_subsection("Mesh");
  if (!prm.get("File").empty()) {
    p.geometry.kind = "mesh";
    p.geometry.file = prm.get("File");
  }
  p.geometry.degree = prm.get("Degree");
  prm.leave_subsection();

  prm.enter_subsection("Attachments");
  p.attachments.proximal = prm.get("Proximal");
  p.attachments.distal = prm.get("Distal");
  p.attachments.protocol = prm.get("Protocol");
  prm.leave_subsection();

  prm.enter_subsection("Muscle");
  for (int i = 0; i < abi::n_props; ++i) {
    if (double* parameter = abi::parameter(p.muscle.law, i))
      *parameter = prm.get_double(abi::property(i).symbol);
  }
  p.muscle.law.energy = prm.get("Energy") == "grown" ? myogrowth::EnergyPer::grown_volume
                                                     : myogrowth::EnergyPer::reference_volume;
  p.muscle.law.integration = prm.get("Integration") == "second order"
                                 ? myogrowth::TimeIntegration::midpoint_flow
                                 : myogrowth::TimeIntegration::backward_euler;
  p.muscle.section = "muscle";
  p.muscle.elastic.law = static_cast<abi::Law>(prm.get_integer("Law"));
  p.volume = prm.get("Volume") == "mean dilatation" ? Volume::mean_dilatation : Volume::pointwise;
  prm.leave_subsection();

  prm.enter_subsection("Tendon");
  p.tendon_length = prm.get_double("Length");
  p.tendon_stiffness = prm.get_double("Stiffness");
  prm.leave_subsection();

  prm.enter_subsection("Fibre");
  p.fibre.kind = prm.get("Kind");
  if (p.fibre.kind == "default" && p.geometry.kind != "mesh") p.fibre.kind = "uniform";
  p.fibre.from = dealii::Utilities::split_string_list(prm.get("From"));
  p.fibre.to = dealii::Utilities::split_string_list(prm.get("To"));
  p.fibre.direction = numbers(prm.get("Direction"));
  p.fibre.angle = prm.get_double("Angle") * std::acos(-1.0) / 180;
  p.fibre.function = prm.get("Function");
  p.fibre.file = prm.get("File");
  prm.leave_subsection();

  prm.enter_subsection("Ends");
  p.ends = prm.get("Kind");
  p.pull = prm.get_double("Pull");
  p.ends_tolerance = prm.get_double("Tolerance");
  prm.leave_subsection();

  prm.enter_subsection("Time");
  p.ramp = prm.get_double("Ramp");
  p.end = prm.get_double("End");
  p.steps = prm.get("Steps");
  p.step = prm.get_double("Step");
  p.longest_step = prm.get_double("Longest");
  p.largest_part = prm.get_double("Part");
  p.time_tolerance = prm.get_double("Tolerance");
  p.times = numbers(prm.get("Times"));
  prm.leave_subsection();

  prm.enter_subsection("Solver");
  p.newton_tolerance = prm.get_double("Newton tolerance");
  p.newton_iterations = static_cast<int>(prm.get_integer("Newton iterations"));
  p.solver = prm.get("Preconditioner");
  p.krylov_tolerance = prm.get_double("Krylov tolerance");
  p.set_up_every_step = prm.get("Set up") == "every step";
  p.predict = prm.get("Predictor") == "true";
  p.dense = prm.get("Assembly") == "dense";
  prm.leave_subsection();

  prm.enter_subsection("Output");
  p.folder = prm.get("Folder");
  p.output_times = numbers(prm.get("Times"));
  p.write_fibres = prm.get("Fibres") == "true";
  p.threshold = prm.get_double("Threshold");
  p.fascicles = static_cast<int>(prm.get_integer("Fascicles"));
  p.checkpoint_every = static_cast<int>(prm.get_integer("Checkpoint every"));
  p.resume = prm.get("Resume") != "false";
  p.force = prm.get("Resume") == "force";
  prm.leave_subsection();
  return p;
}

/// Materials/List, on the muscle of the section Muscle. Throws Error.
std::vector<Parameters::Material> read_materials(const std::string& text, const Parameters& p) {
  std::vector<Parameters::Material> materials;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ';');) {
    const auto fail = [&](const std::string& why) {
      throw Error("Materials/List: '" + common::visible(item) + "': " + why);
    };
    std::istringstream words(item);
    std::string section, kind;
    if (!(words >> section)) continue;
    if (!(words >> kind) || (kind != "muscle" && kind != "tendon"))
      fail("expected NAME and muscle or tendon" +
           (kind.empty() ? std::string() : ", found '" + common::visible(kind) + "'"));
    Parameters::Material material = kind == "muscle" ? p.muscle : p.tendon;
    material.section = section;
    std::vector<std::pair<std::string, std::string>> given;  // names and values
    for (std::string word; words >> word;) {
      const std::size_t equals = word.find('=');
      const std::string name = word.substr(0, equals);
      if (equals == std::string::npos) fail("expected NAME=VALUE, found '" + common::visible(word) + "'");
      for (const auto& other : given) {
        if (other.first == name) fail(common::visible(name) + " is said twice");
      }
      given.emplace_back(name, word.substr(equals + 1));
    }
    const auto number = [&](const std::pair<std::string, std::string>& of) {
      double value;
      if (!common::to_number(of.second, value))
        fail("expected a number after " + of.first + "=, found '" + common::visible(of.second) + "'" +
             common::hint(of.second));
      return value;
    };
    // The law first: it decides which names there are.
    for (const auto& entry : given) {
      if (entry.first != "law") continue;
      const double law = number(entry);
      if (!(law >= 0 && law <= abi::n_laws && law == std::floor(law)))
        fail("law = " + common::text_of(law) + ": elastic law, must be " + elastic_laws());
      material.elastic = p.laws[static_cast<std::size_t>(law)];
    }
    if (material.elastic.law == abi::Law::blemker) {  // whose defaults are those of muscle or of tendon
      for (const auto& entry : given) {
        if (entry.first == "tendon") material.elastic = p.blemker[number(entry) == 1];
      }
    }
    const abi::Law law = material.elastic.law;
    const bool has_constants = law != abi::Law::neo_hookean;
    const abi::LawParameters* table = has_constants ? &abi::parameters_of(law) : nullptr;
    for (const auto& entry : given) {
      if (entry.first == "law") continue;
      if (entry.first == "activation" && material.grows && has_constants) {
        material.activation =
            read_activation(entry.second, [&](const std::string& why) { fail("activation: " + why); });
        continue;
      }
      const int index = abi::find_property(entry.first.c_str());
      double* parameter = abi::parameter(material.law, index);
      if (parameter != nullptr && ((index < 2 && has_constants) || (index > 1 && !material.grows)))
        parameter = nullptr;
      for (int i = 0; i < (has_constants ? table->size : 0); ++i) {
        if (entry.first == table->entry[i].symbol) parameter = material.elastic.p + i;
      }
      if (parameter == nullptr) {
        std::string names = material.grows  ? "a parameter of section Muscle"
                            : has_constants ? "law"
                                            : "c1, c2 or law";
        if (has_constants) {
          names += std::string(material.grows ? " but c1 and c2, law, activation" : "") +
                   " or a constant of elastic law " + std::to_string(static_cast<int>(law)) + " (";
          for (int i = 0; i < table->size; ++i)
            names += (i > 0 ? ", " : "") + std::string(table->entry[i].symbol);
          names += ")";
        } else if (material.grows) {
          names += " or law";
        }
        fail("expected " + names + " as NAME=VALUE, found '" +
             common::visible(entry.first + "=" + entry.second) + "'");
      }
      *parameter = number(entry);
    }
    if (!has_constants) material.activation = {};
    double props[abi::n_props];
    abi::write(material.law, props);
    const int bad = abi::find_bad_entry(props);
    if (bad >= 0)
      fail(std::string(abi::property(bad).symbol) + " must be " + abi::text(abi::property(bad).allowed));
    double constants[abi::most_law_parameters];
    std::copy(material.elastic.p, material.elastic.p + abi::most_law_parameters, constants);
    abi::Text fault;
    if (has_constants && abi::find_parameter_fault(constants, table->size, 0, material.elastic, fault))
      fail(fault);
    const bool says_activation = std::any_of(given.begin(), given.end(),
                                             [](const auto& entry) { return entry.first == "activation"; });
    if (says_activation && is_active(material.activation) && !may_be_active(material.elastic))
      fail("activation must be 0 with tendon = 1, which is never active");
    for (const auto& other : materials) {
      if (other.section == material.section) fail("there is a material for " + material.section + " already");
    }
    materials.push_back(material);
  }
  return materials;
}

/// Fibre/List. Throws Error.
std::vector<Parameters::SetFibre> read_set_fibres(const std::string& text, const Parameters& p) {
  std::vector<Parameters::SetFibre> found;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ';');) {
    const auto fail = [&](const std::string& why) {
      throw Error("Fibre/List: '" + common::visible(item) + "': " + why);
    };
    std::istringstream in(item);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    if (words.empty()) continue;
    Parameters::SetFibre of{words[0], p.fibre};
    of.fibre.kind = words.size() > 1 ? words[1] : "";
    const std::size_t n = words.size() - std::min<std::size_t>(words.size(), 2);
    if (of.fibre.kind == "uniform") {
      of.fibre.direction.clear();
      double x, length = 0;
      for (std::size_t i = 2; i < words.size(); ++i) {
        if (!common::to_number(words[i], x))
          fail("expected a number, found '" + common::visible(words[i]) + "'" + common::hint(words[i]));
        of.fibre.direction.push_back(x);
        length += std::abs(x);
      }
      if (n != 3 || !(length > 0))
        fail("expected a direction of three numbers, of a length > 0, after 'uniform'");
    } else if (of.fibre.kind == "flow") {
      if (n != 2) fail("expected two surfaces after 'flow'");
      of.fibre.from = dealii::Utilities::split_string_list(words[2]);
      of.fibre.to = dealii::Utilities::split_string_list(words[3]);
    } else if (of.fibre.kind != "mesh" || n != 0) {
      fail("expected NAME and uniform X Y Z, flow FROM TO or mesh" +
           (of.fibre.kind.empty() ? std::string() : ", found '" + common::visible(of.fibre.kind) + "'"));
    }
    found.push_back(of);
  }
  return found;
}

/// A law with the constants of its section. Those that are not said are set to the published ones, of muscle
/// or of tendon. Throws Error.
abi::LawChoice constants_of_section(abi::Law law, bool tendon, Entries& entries) {
  const abi::LawParameters& table = abi::parameters_of(law);
  const std::vector<std::string> said = entries.said(table.name);
  double given[abi::most_law_parameters];
  for (int i = 0; i < table.size; ++i) {
    const std::string symbol = table.entry[i].symbol;
    if (std::count(said.begin(), said.end(), table.name + ("/" + symbol)) == 0)
      entries.set_default(table.name, symbol, abi::default_of(law, i, tendon));
    given[i] = entries.prm().get_double({table.name}, symbol);
  }
  abi::LawChoice choice{};
  choice.law = law;
  abi::Text fault;
  if (abi::find_parameter_fault(given, table.size, 0, choice, fault)) {
    const std::string text(fault);  // "SYMBOL = VALUE: what is wrong"
    entries.fail(table.name + ("/" + text.substr(0, text.find(' '))), text.substr(text.find(": ") + 2));
  }
  return choice;
}

/// The elastic laws with the constants of their sections, and which one the muscle has. Throws Error.
void take_laws(Entries& entries, Parameters& p) {
  const bool tendon = entries.prm().get_double({"Blemker"}, "tendon") == 1;
  p.blemker[!tendon] = constants_of_section(abi::Law::blemker, !tendon, entries);
  for (int law = 1; law <= abi::n_laws; ++law)
    p.laws[static_cast<std::size_t>(law)] = constants_of_section(static_cast<abi::Law>(law), tendon, entries);
  p.blemker[tendon] = p.laws[static_cast<std::size_t>(abi::Law::blemker)];
  p.muscle.elastic = p.laws[static_cast<std::size_t>(p.muscle.elastic.law)];
  const std::string activation = entries.prm().get({"Muscle"}, "Activation");
  p.muscle.activation =
      read_activation(activation, [&](const std::string& why) { entries.fail("Muscle/Activation", why); });
}

/// Tells of constants that are said and that no material reads, and refuses an activation of such.
void find_unread(const Entries& entries, Parameters& p) {
  std::vector<Parameters::Material> all = p.materials;
  const bool of_mesh = p.geometry.kind == "mesh";
  if (all.empty()) all.push_back(p.muscle);
  if (!of_mesh && p.tendon_length > 0) all.push_back(p.tendon);
  const auto has_law = [&](int law) {
    return std::any_of(all.begin(), all.end(),
                       [&](const Parameters::Material& m) { return static_cast<int>(m.elastic.law) == law; });
  };
  const auto note = [&](const std::string& entry, int law) {
    p.notes.push_back(entry + " is not read: nothing has elastic law " + std::to_string(law));
  };
  for (const std::string& entry : entries.said("Muscle")) {
    if ((entry == "Muscle/c1" || entry == "Muscle/c2") && !has_law(0)) note(entry, 0);
  }
  for (int law = 1; law <= abi::n_laws; ++law) {
    for (const std::string& entry : entries.said(abi::parameters_of(static_cast<abi::Law>(law)).name)) {
      if (!has_law(law)) note(entry, law);
    }
  }
  const bool reads = std::any_of(all.begin(), all.end(), [](const Parameters::Material& m) {
    return m.grows && may_be_active(m.elastic);
  });
  entries.check(reads || !is_active(p.muscle.activation), "Muscle/Activation",
                "0: no muscle has an elastic law with an active force");
}

/// What one entry's range cannot say.
void check_together(Entries& entries, Parameters& p) {
  const auto check = [&](bool good, const std::string& entry, const std::string& allowed) {
    entries.check(good, entry, allowed);
  };
  double props[abi::n_props];
  abi::write(p.muscle.law, props);
  const int bad = abi::find_bad_entry(props);
  if (bad >= 0)
    check(false, std::string("Muscle/") + abi::property(bad).symbol, abi::text(abi::property(bad).allowed));
  take_laws(entries, p);
  p.tendon = p.muscle;
  p.tendon.section = "tendon";
  p.tendon.grows = false;
  p.tendon.law.c1 *= p.tendon_stiffness;
  p.tendon.law.c2 *= p.tendon_stiffness;
  p.tendon.law.growth.lambda_crit = no_growth;
  p.tendon.law.removal.tau_rev = 0;
  p.tendon.elastic = {};
  p.tendon.activation = {};
  const auto& g = p.geometry;
  const bool mesh = g.kind == "mesh";
  const auto only_with_mesh = [&](const std::string& entry, bool given) {
    check(mesh || !given, entry, "empty without Mesh/File");
  };
  const std::string actions = entries.prm().get({"Attachments"}, "List"),
                    materials = entries.prm().get({"Materials"}, "List"),
                    fibres = entries.prm().get({"Fibre"}, "List");
  only_with_mesh("Attachments/List", !actions.empty());
  only_with_mesh("Attachments/Protocol", !p.attachments.protocol.empty());
  only_with_mesh("Materials/List", !materials.empty());
  only_with_mesh("Fibre/List", !fibres.empty());
  check(mesh || (p.fibre.kind != "flow" && p.fibre.kind != "mesh"), "Fibre/Kind",
        "another one without Mesh/File");
  check(!mesh || p.tendon_length == 0, "Tendon/Length", "0 with Mesh/File, whose tendons are sections");
  check(g.kind != "file" || !g.file.empty(), "Geometry/File", "the name of a file with Geometry/Kind = file");
  // More do not fit deal.II's 32-bit numbers of unknowns.
  constexpr double most_cells = 1e9;
  check(g.kind != "cylinder" || 5. * g.layers * std::pow(8, g.refinements) <= most_cells,
        "Geometry/Refinements", "smaller with these Layers: more than 1e9 cells");
  check(g.kind != "brick" || 1. * g.cells[0] * g.cells[1] * g.cells[2] <= most_cells, "Geometry/Cells",
        "smaller: more than 1e9 cells");
  check(p.fibre.kind != "file" || !p.fibre.file.empty(), "Fibre/File",
        "the name of a file with Fibre/Kind = file");
  check(p.fibre.direction[0] != 0 || p.fibre.direction[1] != 0 || p.fibre.direction[2] != 0,
        "Fibre/Direction", "of a length > 0");
  check(g.kind == "file" || mesh || 2 * p.tendon_length < g.length, "Tendon/Length",
        "less than half of Geometry/Length");
  check(g.kind == "file" || mesh || p.pull > -g.length, "Ends/Pull", "> -Geometry/Length");

  if (p.steps == "listed") {
    check(!p.times.empty(), "Time/Times", "at least one time with Time/Steps = listed");
    p.end = p.times.back();
  } else {
    check(p.end >= p.ramp, "Time/End", ">= Time/Ramp");
  }
  // A run of more steps would not end in a year.
  const double least = shortest_step * p.end;
  const std::string of_end = ">= 1e-9 of the end, which is at " + common::text_of(p.end);
  check(p.ramp >= least, "Time/Ramp", of_end);
  check(p.steps == "listed" || p.step >= least, "Time/Step", of_end);
  check(p.steps != "fixed" || p.end <= most_steps * p.step, "Time/Step",
        "longer: more than a million steps to the end, which is at " + common::text_of(p.end));
  check(p.steps != "adaptive" || p.end <= most_steps * p.longest_step, "Time/Longest",
        "longer: more than a million steps to the end, which is at " + common::text_of(p.end));
  for (std::size_t i = 0; i < p.times.size() && p.steps == "listed"; ++i) {
    check(p.times[i] - (i > 0 ? p.times[i - 1] : 0) >= least, "Time/Times",
          "each greater than the one before by 1e-9 of the last, and > 0; " + common::text_of(p.times[i]) +
              " is not");
  }
  std::sort(p.output_times.begin(), p.output_times.end());
  for (std::size_t i = 0; i < p.output_times.size(); ++i) {
    check(p.output_times[i] - (i > 0 ? p.output_times[i - 1] : 0) >= least, "Output/Times",
          "apart by 1e-9 of the end, and > 0; " + common::text_of(p.output_times[i]) + " is not");
  }

  p.attachments.actions = read_actions(actions, TimeTable({{0, 0}, {p.ramp, 1}}));
  p.materials = read_materials(materials, p);
  find_unread(entries, p);
  p.set_fibres = read_set_fibres(fibres, p);
  if (!p.attachments.protocol.empty())
    p.attachments.stretching =
        read_protocol(p.attachments.protocol, entries.prm().get_double({"Attachments"}, "Cycle"), p.end);

  check(!(p.dense && mesh), "Solver/Assembly", "compact with Mesh/File");
  check(!(p.dense && p.volume == Volume::mean_dilatation), "Solver/Assembly",
        "compact with Muscle/Volume = mean dilatation");
  check(!(p.dense && p.solver == "GAMG"), "Solver/Assembly", "compact with Solver/Preconditioner = GAMG");
#ifndef DEAL_II_WITH_PETSC
  check(p.solver != "GAMG", "Solver/Preconditioner", "ML, this deal.II has no PETSc");
#endif
  check(!p.folder.empty(), "Output/Folder", "the name of a folder");
}

void Entries::read(const std::string& path) {
  common::Rows rows(path, common::Separator::blanks);
  std::map<std::string, std::string> places;  // of the sections
  std::string section;
  while (rows.next()) {
    const std::string word = rows.text(0, "a word");
    if (word == "subsection" && section.empty()) {
      section = rows.text_from(1, "the name of a section");
      if (std::none_of(all_.begin(), all_.end(), [&](const Entry& e) { return e.section == section; }))
        rows.unexpected(1, "a section: " + sections());
      if (!places.emplace(section, rows.place(1)).second)
        rows.fail(1, "section " + section + " is there already, in " + places[section]);
    } else if (word == "set" && !section.empty()) {
      const std::string assignment = rows.text_from(1, "ENTRY = VALUE");
      const std::size_t equals = assignment.find('=');
      if (equals == std::string::npos) rows.unexpected(1, "ENTRY = VALUE");
      using dealii::Utilities::trim;
      set(section, trim(assignment.substr(0, equals)), trim(assignment.substr(equals + 1)), rows.place(1));
    } else if (word == "end" && !section.empty()) {
      rows.ends_after(1);
      section.clear();
    } else {
      rows.unexpected(0,
                      section.empty() ? "'subsection NAME'" : "'set ENTRY = VALUE' or 'end' of " + section);
    }
  }
  if (!section.empty()) throw Error(path + ": section " + section + " has no 'end'");
}

}  // namespace

Parameters read_parameters(const std::string& file, const std::vector<std::string>& overrides) {
  Entries entries;
  if (!file.empty()) entries.read(file);
  for (const std::string& argument : overrides) {
    const std::size_t slash = argument.find('/'), equals = argument.find('=');
    if (slash >= equals || equals == std::string::npos)
      throw Error(common::visible(argument) + ": must be Section/Entry=value");
    entries.set(argument.substr(0, slash), argument.substr(slash + 1, equals - slash - 1),
                argument.substr(equals + 1), "");
  }
  Parameters p = values(entries.prm());
  check_together(entries, p);
  p.entries = entries.texts();
  p.defaults = Entries().texts();
  return p;
}

std::string parameters_help() {
  Entries entries;
  std::ostringstream out;
  entries.prm().print_parameters(out, ParameterHandler::PRM | ParameterHandler::KeepDeclarationOrder);
  return out.str();
}

}  // namespace muscle
