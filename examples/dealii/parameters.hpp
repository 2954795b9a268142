/// @file
/// What the parameter file says; `muscle --help` prints every entry with its meaning and its default.
#ifndef MYOGROWTH_DEALII_PARAMETERS_HPP
#define MYOGROWTH_DEALII_PARAMETERS_HPP

#include <array>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "attachments.hpp"
#include "element.hpp"
#include "ranks.hpp"

namespace muscle {

/// A number as printf writes it.
inline std::string number(const char* format, double x) {
  char text[64];
  std::snprintf(text, sizeof text, format, x);
  return text;
}

/// The shortest step, over the time of the end, and the largest number of steps that a run may ask for.
constexpr double shortest_step = 1e-9, most_steps = 1e6;

/// An elastic stretch that tissue which does not grow never reaches.
constexpr double no_growth = 1000;

struct Parameters {
  struct Geometry {
    std::string kind;        ///< cylinder, brick or file
    double length, radius;   ///< [length]
    double width, height;    ///< of the brick [length]
    int layers;              ///< of the cylinder's coarsest mesh
    int refinements;         ///< of the cylinder
    std::vector<int> cells;  ///< of the brick, along x, y and z
    std::string file;
    std::string degree;  ///< of the file's tetrahedra: as the file, 1 or 2
  } geometry;

  /// What a section of the mesh file is made of.
  struct Material {
    std::string section;
    bool grows = true;                    ///< else it is elastic: tendon, aponeurosis
    myogrowth::FibreGrowth<> law;         ///< growth, and the constants of elastic law 0
    myogrowth::abi::LawChoice elastic{};  ///< the elastic law and its constants
    TimeTable activation;                 ///< not of tendon

    /// The elastic law with the activation at a time; `part`: as TimeTable has it.
    myogrowth::abi::LawChoice elastic_at(double time, double part) const {
      myogrowth::abi::LawChoice now = elastic;
      now.activation = activation.at(time, part);
      return now;
    }
  };
  std::vector<Material> materials;  ///< of Materials/List

  struct Attachments {
    std::vector<Action> actions;   ///< none: the proximal one fixed, the distal one 10 % away
    std::string proximal, distal;  ///< surfaces: the line between their centroids
    std::string protocol;          ///< a study's file, or empty
    TimeTable stretching;          ///< the protocol's stretch - 1
  } attachments;

  Material muscle, tendon;  ///< what a mesh without Materials/List is made of
  std::array<myogrowth::abi::LawChoice, myogrowth::abi::n_laws + 1>
      laws{};                              ///< with the constants of their sections
  myogrowth::abi::LawChoice blemker[2]{};  ///< the same of law 2, of muscle and of tendon
  Volume volume;
  double tendon_length, tendon_stiffness;  ///< [length], [-]

  struct Fibre {
    std::string kind;                   ///< flow, mesh, uniform, oblique, pennate, function or file
    std::vector<std::string> from, to;  ///< surfaces that the flow goes between
    std::vector<double> direction;      ///< uniform
    double angle;                       ///< oblique and pennate [rad]
    std::string function;               ///< three expressions in x, y, z
    std::string file;
  } fibre;
  /// Fibres of a section or set of the mesh file, in the place of the others.
  struct SetFibre {
    std::string set;
    Fibre fibre;
  };
  std::vector<SetFibre> set_fibres;

  std::string ends;  ///< clamped, free or mixed
  double pull;       ///< displacement of the distal end [length]
  double
      ends_tolerance;  ///< how far from an end's plane its nodes may be, over the least height of a cell [-]

  double ramp, end;           ///< [time]
  std::string steps;          ///< adaptive, fixed or listed
  double step, longest_step;  ///< [time]
  double largest_part;        ///< of an attachment's way in one step [-]
  double time_tolerance;      ///< of G in a step [-]
  std::vector<double> times;  ///< ends of the steps, if listed

  double newton_tolerance;  ///< of the forces out of balance, over the reactions [-]
  int newton_iterations;
  std::string solver;       ///< ML or GAMG
  double krylov_tolerance;  ///< of a linear solve, over its right side [-]
  bool set_up_every_step;   ///< of the preconditioner; else when it has become slow
  bool predict;             ///< from the last steps
  bool dense;               ///< the loop that one would write first, to compare with

  std::string folder;
  std::vector<double> output_times;
  double threshold;  ///< of lambda_e, for hot_spots.csv [-]
  int fascicles;     ///< number of streamlines
  bool write_fibres;
  int checkpoint_every;  ///< steps; 0: only when asked to end
  bool resume;           ///< go on from the checkpoint
  bool force;            ///< even if it is one of another run

  /// All entries, "Section/Entry" and value, numbers in their shortest form: what a checkpoint says of its
  /// run.
  std::vector<std::pair<std::string, std::string>> entries;
  std::vector<std::pair<std::string, std::string>> defaults;  ///< the same where nothing is said
  std::vector<std::string> notes;  ///< what is to be told: entries that are said and that nothing reads
};

/// Reads a file and "Section/Entry=value" arguments. Throws Error that names the entry, its value and what is
/// allowed.
Parameters read_parameters(const std::string& file, const std::vector<std::string>& overrides);

/// All entries with their defaults and meanings, as a parameter file.
std::string parameters_help();

}  // namespace muscle

#endif
