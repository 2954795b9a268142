// A plugin of FEBio 4: two materials that grow, their plot variables and log data. README.md says how it is
// built and used.
#include <FEBioMech/FEElasticMaterial.h>
#include <FECore/DumpStream.h>
#include <FECore/FEAnalysis.h>
#include <FECore/FECoreKernel.h>
#include <FECore/FELogElemData.h>
#include <FECore/FEMat3dValuator.h>
#include <FECore/FEModel.h>
#include <FECore/FEModelParam.h>
#include <FECore/FEPlotData.h>
#include <FECore/FESolidDomain.h>
#include <FECore/FESolver.h>
#include <FECore/FEVec3dValuator.h>
#include <FECore/log.h>
#include <FECore/version.h>
#include <FECore/writeplot.h>
#include <myogrowth/elastic/fibre_growth_of.hpp>
#include <myogrowth/version.hpp>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>

#include "../../abi/faults.hpp"

namespace {

using namespace myogrowth;

enum Entry { G, lambda_e, lambda, J, Je, n_entries };
constexpr const char* names[n_entries] = {"sarcomere number", "elastic fibre stretch", "fibre stretch",
                                          "total relative volume", "elastic relative volume"};

// What a point remembers. FEBio saves and restores it by Serialize, around steps that fail as well.
class GrowthPoint : public FEMaterialPointData {
 public:
  explicit GrowthPoint(FEMaterialPointData* next) : FEMaterialPointData(next) {}
  void Init() override {
    FEMaterialPointData::Init();
    for (int i = 0; i < n_entries; ++i) start[i] = end[i] = 1;
  }
  // At the beginning of every step: the state in which the last one ended.
  void Update(const FETimeInfo& time) override {
    FEMaterialPointData::Update(time);
    for (int i = 0; i < n_entries; ++i) start[i] = end[i];
  }
  FEMaterialPointData* Copy() override {
    GrowthPoint* copy = new GrowthPoint(*this);
    if (m_pNext) copy->m_pNext = m_pNext->Copy();
    return copy;
  }
  void Serialize(DumpStream& stream) override {
    FEMaterialPointData::Serialize(stream);
    for (double& x : start) stream& x;
    for (double& x : end) stream& x;
  }

  double start[n_entries], end[n_entries];
};

// Where a step begins, and to which F it goes.
struct Step {
  double F[9], n0[3], G, lambda, dt;
};

enum class Wanted { stress, modulus, energy, points };

mat3ds symmetric(const double s[6]) { return mat3ds(s[0], s[1], s[2], s[3], s[5], s[4]); }

// Parameters, state and conversions of both materials.
class GrowingMaterial : public FEElasticMaterial {
 public:
  explicit GrowingMaterial(FEModel* model) : FEElasticMaterial(model) {
    FibreGrowth<double> defaults;
    for (int i = 0; i < abi::n_props; ++i) {
      if (const double* p = abi::parameter(defaults, i)) parameters[i] = *p;
    }
  }

  FEMaterialPointData* CreateMaterialPointData() override {
    return new GrowthPoint(FEElasticMaterial::CreateMaterialPointData());
  }

  bool Init() override {
    if (!FEElasticMaterial::Init()) return false;
    FibreGrowth<double> constant;
    for (int i = 0; i < abi::n_props; ++i) {
      double* p = abi::parameter(constant, i);
      if (p && parameters[i].isConst()) *p = parameters[i].constValue();
    }
    abi::Text why;
    const bool bad = abi::find_material_fault(constant, why);
    if (bad) feLogError("%s: %s", GetName().c_str(), why);
    return !bad;
  }

  mat3ds Stress(FEMaterialPoint& point) override { return symmetric(update(point, Wanted::stress).stress); }
  double StrainEnergyDensity(FEMaterialPoint& point) override { return update(point, Wanted::energy).psi; }

  // FEBio's own takes differences of the energy, growth included, which is no stress.
  mat3ds SecantStress(FEMaterialPoint& point, bool second_piola) override {
    const mat3ds s = Stress(point);
    return second_piola ? point.ExtractData<FEElasticMaterialPoint>()->pull_back(s) : s;
  }

  // Growth makes the tangent unsymmetric; this is FEBio's name for one that is. A symmetric stiffness would
  // be its upper triangle, so there the symmetric part is given, by Tangent.
  bool UseSecantTangent() override {
    FEAnalysis* step = GetFEModel()->GetCurrentStep();
    const FESolver* solver = step ? step->GetFESolver() : nullptr;
    return !solver || solver->m_msymm != REAL_SYMMETRIC;
  }
  // In the material frame it is pulled back.
  tens4dmm SecantTangent(FEMaterialPoint& point, bool in_material_frame) override {
    const Result r = update(point, Wanted::modulus);
    tens4dmm c(0.0);
    for (int b = 0; b < 6; ++b) {
      for (int a = 0; a < 6; ++a) {
        c(symmetric_row(a), symmetric_column(a), symmetric_row(b), symmetric_column(b)) =
            r.modulus[a + 6 * b];
      }
    }
    if (!in_material_frame) return c;
    const FEElasticMaterialPoint& whole = *point.ExtractData<FEElasticMaterialPoint>();
    return c.pp(whole.m_F.inverse()) * whole.m_J;
  }
  tens4ds Tangent(FEMaterialPoint& point) override { return SecantTangent(point, false).supersymm(); }

  FEParamDouble parameters[abi::n_props];  // by their entries in PROPS
  int energy = 0, integration = 0;
  FEVec3dValuator* fibre = nullptr;

 protected:
  // The law: what update_point gives, and the modulus of the Jaumann rate of tau if it is wanted.
  virtual UpdateStatus take(const Step& step, const FibreGrowth<double>& growth, FEMaterialPoint& point,
                            Wanted wanted, PointUpdate<double>& u, double c[36]) = 0;

  bool begin(FEMaterialPoint& point, FibreGrowth<double>& growth, Step& step, abi::Text& why) {
    for (int i = 0; i < abi::n_props; ++i) {
      if (double* p = abi::parameter(growth, i)) *p = parameters[i](point);
    }
    growth.energy = energy ? EnergyPer::grown_volume : EnergyPer::reference_volume;
    growth.integration = integration ? TimeIntegration::midpoint_flow : TimeIntegration::backward_euler;
    const GrowthPoint& state = *point.ExtractData<GrowthPoint>();
    const FEElasticMaterialPoint& whole = *point.ExtractData<FEElasticMaterialPoint>();
    const vec3d n0 = GetLocalCS(point) * fibre->unitVector(point);
    for (int i = 0; i < 9; ++i) step.F[i] = whole.m_F(i % 3, i / 3);
    step.n0[0] = n0.x, step.n0[1] = n0.y, step.n0[2] = n0.z;
    step.G = state.start[G], step.lambda = state.start[lambda], step.dt = CurrentTimeIncrement();
    return !abi::find_material_fault(growth, why);
  }

 private:
  // FEBio's stress is Cauchy's, and its modulus belongs to the Truesdell rate.
  struct Result {
    double stress[6], modulus[36], psi;
  };

  Result update(FEMaterialPoint& point, Wanted wanted) {
    FibreGrowth<double> growth;
    Step step;
    PointUpdate<double> u;
    double c[36];
    abi::Text why;
    if (begin(point, growth, step, why)) {
      const UpdateStatus status = take(step, growth, point, wanted, u, c);
      if (status == UpdateStatus::ok) {
        const double end[n_entries] = {u.G, u.lambda_e, u.lambda, u.J, u.Je};
        std::copy(end, end + n_entries, point.ExtractData<GrowthPoint>()->end);
        Result r;
        cauchy_from_kirchhoff(u.J, u.tau, r.stress);
        truesdell_from_jaumann(u.tau, c, r.modulus);
        for (double& x : r.modulus) x /= u.J;
        r.psi = u.psi;
        return r;
      }
      abi::tell(why, "%s", abi::text(status));
    }
    feLogError("%s: %s", GetName().c_str(), why);
    // Not a number: FEBio ends the step, and tries a shorter one.
    Result r;
    std::fill_n(r.stress, 6, std::numeric_limits<double>::quiet_NaN());
    std::fill_n(r.modulus, 36, std::numeric_limits<double>::quiet_NaN());
    r.psi = std::numeric_limits<double>::quiet_NaN();
    return r;
  }

  DECLARE_FECORE_CLASS();
};

BEGIN_FECORE_CLASS(GrowingMaterial, FEElasticMaterial)
FibreGrowth<double> material;
for (int i = 2; i < abi::n_props; ++i) {  // but for c1 and c2
  if (abi::parameter(material, i)) ADD_PARAMETER(parameters[i], abi::property(i).symbol);
}
ADD_PARAMETER(energy, FE_RANGE_CLOSED(0, 1), "energy");
ADD_PARAMETER(integration, FE_RANGE_CLOSED(0, 1), "integration");
ADD_PROPERTY(fibre, "fiber");
ADD_PROPERTY(m_Q, "mat_axis")->SetFlags(FEProperty::Optional);
END_FECORE_CLASS();

// Eq. 3's muscle, by its closed form.
class MyogrowthFibreGrowth : public GrowingMaterial {
 public:
  using GrowingMaterial::GrowingMaterial;

 private:
  UpdateStatus take(const Step& s, const FibreGrowth<double>& growth, FEMaterialPoint&, Wanted,
                    PointUpdate<double>& u, double c[36]) override {
    update_point(growth, s.F, s.n0, s.G, s.lambda, s.dt, u);
    spatial_modulus(u, c);
    return u.status;
  }
  DECLARE_FECORE_CLASS();
};

BEGIN_FECORE_CLASS(MyogrowthFibreGrowth, GrowingMaterial)
ADD_PARAMETER(parameters[0], abi::property(0).symbol);
ADD_PARAMETER(parameters[1], abi::property(1).symbol);
END_FECORE_CLASS();

// A material of FEBio at a point, as an elastic law of the library (elastic/response.hpp). FEBio's materials
// take the deformation from the point; so while one is asked, the point has that of the elastic part.
struct FEBioLaw {
  FEElasticMaterial* material;
  FEMaterialPoint* point;
  const Step* step;
  Wanted wanted;
  const FETimeInfo* time;  // with Wanted::points

  struct Kept {  // and has its own back at the end, whatever happens
    FEElasticMaterialPoint& place;
    mat3d F, L;
    double J;
    mat3ds s;
    explicit Kept(FEElasticMaterialPoint& p) : place(p), F(p.m_F), L(p.m_L), J(p.m_J), s(p.m_s) {}
    Kept(const Kept&) = delete;
    ~Kept() { place.m_F = F, place.m_L = L, place.m_J = J, place.m_s = s; }
  };

  void evaluate(const double Fe[9], const double n0[3], const double&, ElasticResponse<double>& out) const {
    FEElasticMaterialPoint& place = *point->ExtractData<FEElasticMaterialPoint>();
    const Kept whole(place);
    for (int i = 0; i < 9; ++i) place.m_F(i % 3, i / 3) = Fe[i];
    place.m_J = determinant(Fe);
    // The rate, for viscous materials. FEBio's is (F - F_n) F^-1 / dt.
    if (step->dt > 0) {
      const vec3d n(n0[0], n0[1], n0[2]);
      const mat3d F_n = whole.F - whole.L * whole.F * step->dt;
      const mat3d Fe_n = F_n + (F_n * n & n) * (1 / step->G - 1);
      place.m_L = (place.m_F - Fe_n) * place.m_F.inverse() * (1 / step->dt);
    }

    out = ElasticResponse<double>{};
    if (wanted == Wanted::points) return material->UpdateSpecializedMaterialPoints(*point, *time);
    const mat3ds s = place.m_s = material->Stress(*point);
    if (wanted == Wanted::energy) out.psi = material->StrainEnergyDensity(*point);
    for (int a = 0; a < 6; ++a) out.tau[a] = place.m_J * s(symmetric_row(a), symmetric_column(a));
    if (wanted != Wanted::modulus) return;
    const tens4dmm modulus = material->SolidTangent(*point);
    for (int b = 0; b < 6; ++b) {
      for (int a = 0; a < 6; ++a) {
        out.c[a + 6 * b] =
            place.m_J * modulus(symmetric_row(a), symmetric_column(a), symmetric_row(b), symmetric_column(b));
      }
    }
    add_rate(out.tau, out.c);  // from Truesdell's modulus Jaumann's
  }
};

// Growth of any elastic material of FEBio.
class MyogrowthKinematicGrowth : public GrowingMaterial {
 public:
  using GrowingMaterial::GrowingMaterial;

  FEMaterialPointData* CreateMaterialPointData() override {
    return new GrowthPoint(elastic->CreateMaterialPointData());
  }

  bool Init() override {
    const std::string type = elastic->GetTypeStr() ? elastic->GetTypeStr() : "";
    const auto refuse = [&](const char* why) {
      feLogError("%s: <elastic type=\"%s\">: %s", GetName().c_str(), type.c_str(), why);
      return false;
    };
    for (const char* of_own : {"remodeling solid", "micro-material", "micro-material2O", "mindlin elastic"}) {
      if (type == of_own)
        return refuse("its elements are FEBio's own for it, so it cannot be part of a material.");
    }
    const std::unique_ptr<FEMaterialPointData> data(elastic->CreateMaterialPointData());
    if (data->ExtractData<GrowthPoint>()) return refuse("it or a part of it grows by myogrowth already.");
    if (!data->ExtractData<FEElasticMaterialPoint>())
      return refuse("its points have no deformation of their own.");
    return GrowingMaterial::Init();
  }

  // For materials that prepare their points before they are asked for a stress.
  void UpdateSpecializedMaterialPoints(FEMaterialPoint& point, const FETimeInfo& time) override {
    FibreGrowth<double> growth;
    Step step;
    ElasticPointUpdate<double> u;
    abi::Text why;
    if (!begin(point, growth, step, why)) return;  // the stress, which is asked for next, tells why
    update_point(of(growth, FEBioLaw{elastic, &point, &step, Wanted::points, &time}), step.F, step.n0, step.G,
                 step.lambda, step.dt, u);
  }

  FEElasticMaterial* elastic = nullptr;

 private:
  static FibreGrowthOf<FEBioLaw> of(const FibreGrowth<double>& g, const FEBioLaw& law) {
    return {law, g.growth, g.removal, g.energy, g.integration};
  }
  UpdateStatus take(const Step& s, const FibreGrowth<double>& growth, FEMaterialPoint& point, Wanted wanted,
                    PointUpdate<double>& u, double c[36]) override {
    ElasticPointUpdate<double> all;
    update_point(of(growth, FEBioLaw{elastic, &point, &s, wanted, nullptr}), s.F, s.n0, s.G, s.lambda, s.dt,
                 all);
    spatial_modulus(all, c);
    u = all;
    return u.status;
  }
  DECLARE_FECORE_CLASS();
};

BEGIN_FECORE_CLASS(MyogrowthKinematicGrowth, GrowingMaterial)
ADD_PROPERTY(elastic, "elastic");
END_FECORE_CLASS();

template <int entry>
double state_of(const FEMaterialPoint& point) {
  const GrowthPoint* growth = point.ExtractData<GrowthPoint>();
  return growth ? growth->end[entry] : 1;
}

// An entry of the state for the plot file: the mean of an element's points.
template <int entry>
class PlotState : public FEPlotDomainData {
 public:
  explicit PlotState(FEModel* model) : FEPlotDomainData(model, PLT_FLOAT, FMT_ITEM) {}
  bool Save(FEDomain& domain, FEDataStream& stream) override {
    writeAverageElementValue<double>(domain, stream,
                                     [](const FEMaterialPoint& point) { return state_of<entry>(point); });
    return true;
  }
};

// The same for the log file.
template <int entry>
class LogState : public FELogElemData {
 public:
  explicit LogState(FEModel* model) : FELogElemData(model) {}
  double value(FEElement& element) override {
    double sum = 0;
    for (int i = 0; i < element.GaussPoints(); ++i) sum += state_of<entry>(*element.GetMaterialPoint(i));
    return sum / element.GaussPoints();
  }
};

template <int entry>
void register_state() {
  static FERegisterClass_T<PlotState<entry>> plot(PlotState<entry>::superClassID(), "PlotState",
                                                  PlotState<entry>::BaseClassName(), names[entry]);
  static FERegisterClass_T<LogState<entry>> log(LogState<entry>::superClassID(), "LogState",
                                                LogState<entry>::BaseClassName(), names[entry]);
}

}  // namespace

extern "C" FECORE_EXPORT unsigned int GetSDKVersion() { return FE_SDK_VERSION; }

extern "C" FECORE_EXPORT void GetPluginVersion(int& major, int& minor, int& patch) {
  major = MYOGROWTH_VERSION_MAJOR;
  minor = MYOGROWTH_VERSION_MINOR;
  patch = MYOGROWTH_VERSION_PATCH;
}

extern "C" FECORE_EXPORT void PluginInitialize(FECoreKernel& kernel) {
  FECoreKernel::SetInstance(&kernel);
  REGISTER_FECORE_CLASS(MyogrowthFibreGrowth, "myogrowth fibre growth");
  REGISTER_FECORE_CLASS(MyogrowthKinematicGrowth, "myogrowth kinematic growth");
  register_state<G>();
  register_state<lambda_e>();
  register_state<lambda>();
  register_state<J>();
  register_state<Je>();
}
