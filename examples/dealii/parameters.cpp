#include "parameters.hpp"

#include <deal.II/base/parameter_handler.h>

#include <cmath>
#include <fstream>
#include <sstream>

namespace muscle {
namespace {

using dealii::ParameterHandler;
namespace Patterns = dealii::Patterns;

const double any = std::numeric_limits<double>::max(), tiny = std::numeric_limits<double>::min();

void declare(ParameterHandler& prm) {
  const auto section = [&](const std::string& name, auto entries) {
    prm.enter_subsection(name);
    entries();
    prm.leave_subsection();
  };
  const auto real = [&](const std::string& name, const std::string& start, double least, double most,
                        const std::string& doc) {
    prm.declare_entry(name, start, Patterns::Double(least, most), doc);
  };
  const auto whole = [&](const std::string& name, const std::string& start, int least, int most,
                         const std::string& doc) {
    prm.declare_entry(name, start, Patterns::Integer(least, most), doc);
  };
  const auto choice = [&](const std::string& name, const std::string& start, const std::string& of,
                          const std::string& doc) {
    prm.declare_entry(name, start, Patterns::Selection(of), doc);
  };
  const auto list = [&](const std::string& name, const std::string& start, const Patterns::PatternBase& item,
                        unsigned least, unsigned most, const std::string& doc) {
    prm.declare_entry(name, start, Patterns::List(item, least, most), doc);
  };
  const auto text = [&](const std::string& name, const std::string& start, const std::string& doc) {
    prm.declare_entry(name, start, Patterns::Anything(), doc);
  };

  section("Geometry", [&] {
    choice("Kind", "cylinder", "cylinder|brick|file",
           "cylinder: hexahedra, along z, cut to pi r^2 l in spite of its straight edges; brick: hexahedra; "
           "file: hexahedra "
           "and wedges as examples/calculix/cylinder_mesh.py writes them. The ends are the planes of least "
           "and largest z");
    real("Length", "400", tiny, any, "of cylinder and brick, along z [length]");
    real("Radius", "10", tiny, any, "of the cylinder [length]");
    real("Width", "10", tiny, any, "of the brick, along x [length]");
    real("Height", "10", tiny, any, "of the brick, along y [length]");
    whole("Layers", "16", 1, 100000, "of the cylinder's coarsest mesh, which has 5 cells a layer [-]");
    whole("Refinements", "2", 0, 8, "of the cylinder: each makes eight cells of one [-]");
    list("Cells", "4, 4, 4", Patterns::Integer(1, 10000), 3, 3, "of the brick along x, y, z [-]");
    text("File", "", "the mesh, if Kind = file; relative to the folder the program is started in");
  });
  section("Muscle", [&] {
    real("c1", "16", -any, any, "first Lame constant, > -2/3 c2 [stress]");
    real("c2", "4", tiny, any, "second Lame constant [stress]");
    real("tau", "0.5", tiny, any, "time constant of growth [time]");
    real("gamma", "2", 0, any, "shape exponent of the adaptation function [-]");
    real("G_max", "1.1", 1 + 1e-12, any, "largest relative serial sarcomere number [-]");
    real("lambda_crit", "1.01", tiny, any, "elastic fibre stretch above which sarcomeres are added [-]");
    choice("Energy", "reference", "reference|grown", "the volume that the elastic energy is counted per");
    choice("Integration", "second order", "backward Euler|second order", "of growth in time");
    choice("Volume", "pointwise", "pointwise|mean dilatation",
           "mean dilatation for nearly incompressible muscle, c1 >> c2, where pointwise locks");
  });
  section("Tendon", [&] {
    real("Length", "0", 0, any, "of a layer at each end that does not grow; 0: none [length]");
    real("Stiffness", "100", tiny, any, "of that layer, over the muscle's [-]");
  });
  section("Fibre", [&] {
    choice("Kind", "uniform", "uniform|oblique|pennate|function|file",
           "uniform: Direction; oblique: at Angle to z in the x-z plane; pennate: the same, inclined towards "
           "the plane x = 0 "
           "from either side; function: of the place; file: rows of x y z n1 n2 n3, the nearest row holds");
    list("Direction", "0, 0, 1", Patterns::Double(), 3, 3, "any length > 0");
    real("Angle", "0", -90, 90, "[degrees]");
    text("Function", "0; 0; 1", "three expressions in x, y, z, parted by semicolons; any length > 0");
    text("File", "", "relative to the folder the program is started in");
  });
  section("Ends", [&] {
    choice("Kind", "clamped", "clamped|free|mixed",
           "clamped; free to contract in their planes; mixed: the proximal end clamped, the distal one free "
           "to contract");
    real("Pull", "40", -any, any, "displacement of the distal end along z at the end of the ramp [length]");
  });
  section("Time", [&] {
    real("Ramp", "1", tiny, any, "until when the pull grows, linearly; then it is held [time]");
    real("End", "42", tiny, any, "[time]");
    choice("Steps", "adaptive", "adaptive|fixed|listed",
           "adaptive: from Step on as long as Tolerance allows; fixed: Step each; listed: to Times");
    real("Step", "0.02", tiny, any, "the first step, or each [time]");
    real("Longest", "4", tiny, any,
         "no step is longer; while the pull grows, none is longer than a tenth of Ramp [time]");
    real("Tolerance", "1e-4", tiny, 1, "of the time error of G in a step, as the library estimates it [-]");
    list("Times", "", Patterns::Double(0, any), 0, 1000000,
         "ends of the steps; the last one takes the place of End [time]");
  });
  section("Solver", [&] {
    real("Newton tolerance", "1e-8", 1e-14, 1e-2,
         "norm of the forces out of balance, over that of the reactions [-]");
    whole("Newton iterations", "12", 1, 1000, "more than these, and the step is cut [-]");
    choice("Preconditioner", "ML", "ML|GAMG",
           "algebraic multigrid of Trilinos or of PETSc; GMRES, preconditioned on the right");
    real("Krylov tolerance", "1e-4", 1e-14, 0.1,
         "of a linear solve, over its right side; no solve goes below a tenth of Newton's [-]");
    choice(
        "Set up", "when slow", "when slow|every step",
        "of the preconditioner: when slow: when it takes half as many iterations again as when it was new");
    choice(
        "Assembly", "compact", "compact|dense",
        "dense: the loop one would write first, to compare with: P and dP/dF of every point, 9 x 9 products, "
        "insertion by "
        "deal.II, a tangent at every check of Newton's method; pointwise Volume and Preconditioner ML only");
  });
  section("Output", [&] {
    text("Folder", "out/mpi", "of all results; made if it is not there");
    list("Times", "1, 7, 14, 28, 42", Patterns::Double(0, any), 0, 10000,
         "when fields are written, beside the end; steps end there; empty: none at all [time]");
    whole("Checkpoint every", "20", 0, 1000000, "so many steps; 0: only on SIGTERM or SIGUSR1 [-]");
    prm.declare_entry("Resume", "false", Patterns::Bool(),
                      "go on from the checkpoint in Folder, on any number of ranks");
  });
}

std::vector<double> numbers(const std::string& text) {
  return dealii::Utilities::string_to_double(dealii::Utilities::split_string_list(text));
}

template <class T>
std::string said(const std::string& entry, const T& value, const std::string& allowed) {
  std::ostringstream out;
  out << entry << " = " << value << ": must be " << allowed;
  return out.str();
}

void check(bool good, const std::string& message) {
  if (!good) throw Error(message);
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

  prm.enter_subsection("Muscle");
  p.muscle.c1 = prm.get_double("c1");
  p.muscle.c2 = prm.get_double("c2");
  p.muscle.growth.growth_time = prm.get_double("tau");
  p.muscle.growth.gamma = prm.get_double("gamma");
  p.muscle.growth.G_max = prm.get_double("G_max");
  p.muscle.growth.lambda_crit = prm.get_double("lambda_crit");
  p.muscle.energy = prm.get("Energy") == "grown" ? myogrowth::EnergyPer::grown_volume
                                                 : myogrowth::EnergyPer::reference_volume;
  p.muscle.integration = prm.get("Integration") == "second order"
                             ? myogrowth::TimeIntegration::midpoint_flow
                             : myogrowth::TimeIntegration::backward_euler;
  p.volume = prm.get("Volume") == "mean dilatation" ? Volume::mean_dilatation : Volume::pointwise;
  prm.leave_subsection();

  prm.enter_subsection("Tendon");
  p.tendon_length = prm.get_double("Length");
  p.tendon_stiffness = prm.get_double("Stiffness");
  prm.leave_subsection();

  prm.enter_subsection("Fibre");
  p.fibre.kind = prm.get("Kind");
  p.fibre.direction = numbers(prm.get("Direction"));
  p.fibre.angle = prm.get_double("Angle") * std::acos(-1.0) / 180;
  p.fibre.function = prm.get("Function");
  p.fibre.file = prm.get("File");
  prm.leave_subsection();

  prm.enter_subsection("Ends");
  p.ends = prm.get("Kind");
  p.pull = prm.get_double("Pull");
  prm.leave_subsection();

  prm.enter_subsection("Time");
  p.ramp = prm.get_double("Ramp");
  p.end = prm.get_double("End");
  p.steps = prm.get("Steps");
  p.step = prm.get_double("Step");
  p.longest_step = prm.get_double("Longest");
  p.time_tolerance = prm.get_double("Tolerance");
  p.times = numbers(prm.get("Times"));
  prm.leave_subsection();

  prm.enter_subsection("Solver");
  p.newton_tolerance = prm.get_double("Newton tolerance");
  p.newton_iterations = static_cast<int>(prm.get_integer("Newton iterations"));
  p.solver = prm.get("Preconditioner");
  p.krylov_tolerance = prm.get_double("Krylov tolerance");
  p.set_up_every_step = prm.get("Set up") == "every step";
  p.dense = prm.get("Assembly") == "dense";
  prm.leave_subsection();

  prm.enter_subsection("Output");
  p.folder = prm.get("Folder");
  p.output_times = numbers(prm.get("Times"));
  p.checkpoint_every = static_cast<int>(prm.get_integer("Checkpoint every"));
  p.resume = prm.get_bool("Resume");
  prm.leave_subsection();
  return p;
}

/// What one entry's range cannot say.
void check_together(Parameters& p) {
  check(3 * p.muscle.c1 > -2 * p.muscle.c2,
        said("Muscle/c1", p.muscle.c1, "> -2/3 c2 (positive bulk modulus)"));
  check(p.geometry.kind != "file" || !p.geometry.file.empty(),
        "Geometry/File is empty: Geometry/Kind = file needs it");
  check(p.fibre.kind != "file" || !p.fibre.file.empty(), "Fibre/File is empty: Fibre/Kind = file needs it");
  check(p.fibre.direction[0] != 0 || p.fibre.direction[1] != 0 || p.fibre.direction[2] != 0,
        "Fibre/Direction = 0, 0, 0: must be of a length > 0");
  check(p.geometry.kind == "file" || 2 * p.tendon_length < p.geometry.length,
        said("Tendon/Length", p.tendon_length, "less than half of Geometry/Length"));
  check(p.geometry.kind == "file" || p.pull > -p.geometry.length,
        said("Ends/Pull", p.pull, "> -Geometry/Length"));
  if (p.steps == "listed") {
    check(!p.times.empty(), "Time/Times is empty: Time/Steps = listed needs it");
    double before = 0;
    for (double t : p.times) {
      check(t > before, said("Time/Times: an entry", t, "greater than the one before, and > 0"));
      before = t;
    }
    p.end = p.times.back();
  }
  check(p.end >= p.ramp || p.steps == "listed", said("Time/End", p.end, ">= Time/Ramp"));
  check(!(p.dense && p.volume == Volume::mean_dilatation),
        "Solver/Assembly = dense: must be compact with Muscle/Volume = mean dilatation");
  check(!(p.dense && p.solver == "GAMG"),
        "Solver/Assembly = dense: must be compact with Solver/Preconditioner = GAMG");
#ifndef DEAL_II_WITH_PETSC
  check(p.solver != "GAMG", "Solver/Preconditioner = GAMG: must be ML, this deal.II has no PETSc");
#endif
}

}  // namespace

Parameters read_parameters(const std::string& file, const std::vector<std::string>& overrides) {
  ParameterHandler prm;
  declare(prm);
  std::string now;  // the argument that is read
  try {
    if (!file.empty()) {
      check(std::ifstream(file).good(), file + ": cannot be read");
      prm.parse_input(file);
    }
    for (const std::string& argument : overrides) {
      now = argument;
      const std::size_t slash = argument.find('/'), equals = argument.find('=');
      check(slash < equals && equals != std::string::npos, argument + ": must be Section/Entry=value");
      prm.parse_input_from_string("subsection " + argument.substr(0, slash) + "\nset " +
                                  argument.substr(slash + 1, equals - slash - 1) + " = " +
                                  argument.substr(equals + 1) + "\nend\n");
    }
    Parameters p = values(prm);
    check_together(p);
    return p;
  } catch (const dealii::ExceptionBase& e) {
    // deal.II's text, without its line breaks; of an argument it does not know but a line of its own.
    std::ostringstream text;
    e.print_info(text);
    std::istringstream words(text.str());
    std::string line, word;
    while (words >> word) line += (line.empty() ? "" : " ") + word;
    const std::size_t of_argument = line.find("of file <input string>: ");
    if (of_argument != std::string::npos) line = now + ": " + line.substr(of_argument + 24);
    throw Error(line);
  }
}

std::string parameters_help() {
  ParameterHandler prm;
  declare(prm);
  std::ostringstream out;
  prm.print_parameters(out, ParameterHandler::PRM | ParameterHandler::KeepDeclarationOrder);
  return out.str();
}

}  // namespace muscle
