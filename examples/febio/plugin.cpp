// A plugin of FEBio 4: the material `myogrowth fibre growth`, its plot variables and its log data. It goes
// through the C API; README.md says how it is built and used.
#include <FEBioMech/FEElasticMaterial.h>
#include <FECore/DumpStream.h>
#include <FECore/FECoreKernel.h>
#include <FECore/FELogElemData.h>
#include <FECore/FEModelParam.h>
#include <FECore/FEPlotData.h>
#include <FECore/FESolidDomain.h>
#include <FECore/FEVec3dValuator.h>
#include <FECore/log.h>
#include <FECore/version.h>
#include <FECore/writeplot.h>
#include <myogrowth.h>

#include <limits>

namespace {

constexpr int n_statev = 8;  // G, lambda_e, lambda, J, Je, n0
constexpr const char* names[] = {"sarcomere number", "elastic fibre stretch", "fibre stretch",
                                 "total relative volume", "elastic relative volume"};

// What a point remembers. FEBio saves and restores it by Serialize, around steps that fail as well.
class GrowthPoint : public FEMaterialPointData {
 public:
  explicit GrowthPoint(FEMaterialPointData* next) : FEMaterialPointData(next) {}
  void Init() override {
    FEMaterialPointData::Init();
    for (double& x : start) x = 0;  // not known yet: G = 1
    for (int i = 0; i < n_statev; ++i) end[i] = i < 5 ? 1 : 0;
  }
  // At the beginning of every step: the state in which the last one ended.
  void Update(const FETimeInfo& time) override {
    FEMaterialPointData::Update(time);
    for (int i = 0; i < n_statev; ++i) start[i] = end[i];
    for (int i = 5; i < n_statev; ++i) start[i] = 0;  // the fibre is that of the model
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

  double start[n_statev], end[n_statev];
};

class MyogrowthFibreGrowth : public FEElasticMaterial {
 public:
  explicit MyogrowthFibreGrowth(FEModel* model) : FEElasticMaterial(model) {
    c1 = 16, c2 = 4, tau = 0.5, gamma = 2, G_max = 1.1, lambda_crit = 1.01;  // the paper's: kPa, days
  }

  FEMaterialPointData* CreateMaterialPointData() override {
    return new GrowthPoint(FEElasticMaterial::CreateMaterialPointData());
  }

  mat3ds Stress(FEMaterialPoint& point) override {
    Result r;
    update(point, r, false);
    return mat3ds(r.stress[0], r.stress[1], r.stress[2], r.stress[3], r.stress[5],
                  r.stress[4]);  // xx yy zz xy yz xz
  }

  double StrainEnergyDensity(FEMaterialPoint& point) override {
    Result r;
    update(point, r, false);
    return r.psi;
  }

  // Growth makes the tangent unsymmetric; FEBio's name for one that is.
  bool UseSecantTangent() override { return true; }

  // FEBio's modulus belongs to the Truesdell rate, DDSDDE to Jaumann's: c = DDSDDE - (d_ik s_jl + d_il s_jk +
  // d_jk s_il
  // + d_jl s_ik) / 2. In the material frame it is pulled back.
  tens4dmm SecantTangent(FEMaterialPoint& point, bool in_material_frame) override {
    Result r;
    update(point, r, true);
    const mat3ds s(r.stress[0], r.stress[1], r.stress[2], r.stress[3], r.stress[5], r.stress[4]);
    const int voigt[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    const auto d = [](int i, int j) { return i == j ? 0.5 : 0.0; };
    tens4dmm c(0.0);
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) {
          for (int l = k; l < 3; ++l) {
            c(i, j, k, l) = r.ddsdde[voigt[i][j] + 6 * voigt[k][l]] - d(i, k) * s(j, l) - d(i, l) * s(j, k) -
                            d(j, k) * s(i, l) - d(j, l) * s(i, k);
          }
        }
      }
    }
    if (!in_material_frame) return c;
    const FEElasticMaterialPoint& elastic = *point.ExtractData<FEElasticMaterialPoint>();
    return c.pp(elastic.m_F.inverse()) * elastic.m_J;
  }
  // The symmetric part, for what asks for no other.
  tens4ds Tangent(FEMaterialPoint& point) override { return SecantTangent(point, false).supersymm(); }

  FEParamDouble c1, c2, tau, gamma, G_max, lambda_crit;
  FEVec3dValuator* fibre = nullptr;

 private:
  struct Result {
    double stress[6], ddsdde[36], psi;
  };

  void update(FEMaterialPoint& point, Result& r, bool with_tangent) {
    const FEElasticMaterialPoint& elastic = *point.ExtractData<FEElasticMaterialPoint>();
    GrowthPoint& growth = *point.ExtractData<GrowthPoint>();
    const vec3d n0 = GetLocalCS(point) * fibre->unitVector(point);
    const double props[] = {c1(point),          c2(point), tau(point), gamma(point), G_max(point),
                            lambda_crit(point), n0.x,      n0.y,       n0.z};
    double F[9];
    for (int i = 0; i < 9; ++i) F[i] = elastic.m_F(i % 3, i / 3);
    char why[200] = "";
    const int status = myogrowth_update(props, 9, F, growth.start, growth.end, n_statev,
                                        CurrentTimeIncrement(), MYOGROWTH_CAUCHY, r.stress,
                                        with_tangent ? r.ddsdde : nullptr, &r.psi, why, sizeof why);
    if (status == MYOGROWTH_OK) return;
    feLogError("%s: %s", GetName().c_str(), why);
    // Not a number: FEBio ends the step, and tries a shorter one.
    for (double& x : r.stress) x = std::numeric_limits<double>::quiet_NaN();
    for (double& x : r.ddsdde) x = std::numeric_limits<double>::quiet_NaN();
    r.psi = std::numeric_limits<double>::quiet_NaN();
  }

  DECLARE_FECORE_CLASS();
};

BEGIN_FECORE_CLASS(MyogrowthFibreGrowth, FEElasticMaterial)
ADD_PARAMETER(c1, FE_RANGE_GREATER_OR_EQUAL(0.0), "c1");
ADD_PARAMETER(c2, FE_RANGE_GREATER(0.0), "c2");
ADD_PARAMETER(tau, FE_RANGE_GREATER(0.0), "tau");
ADD_PARAMETER(gamma, FE_RANGE_GREATER_OR_EQUAL(0.0), "gamma");
ADD_PARAMETER(G_max, FE_RANGE_GREATER(1.0), "G_max");
ADD_PARAMETER(lambda_crit, FE_RANGE_GREATER(0.0), "lambda_crit");
ADD_PROPERTY(fibre, "fiber");
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

extern "C" FECORE_EXPORT void PluginInitialize(FECoreKernel& kernel) {
  FECoreKernel::SetInstance(&kernel);
  REGISTER_FECORE_CLASS(MyogrowthFibreGrowth, "myogrowth fibre growth");
  register_state<0>();
  register_state<1>();
  register_state<2>();
  register_state<3>();
  register_state<4>();
}
