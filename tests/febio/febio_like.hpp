// A stand-in for the few classes of FEBio 4 that examples/febio/plugin.cpp uses, by FEBio's names and
// conventions: order xx yy zz xy yz xz in the constructor of mat3ds, a modulus with minor symmetries, states
// that are saved and restored by one and the same function, materials within materials.
#ifndef MYOGROWTH_TESTS_FEBIO_LIKE_HPP
#define MYOGROWTH_TESTS_FEBIO_LIKE_HPP

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#define FECORE_EXPORT
#define FE_SDK_VERSION 0x040b00u

struct vec3d {
  double x, y, z;
  vec3d() : vec3d(0, 0, 0) {}
  vec3d(double x_, double y_, double z_) : x(x_), y(y_), z(z_) {}
  vec3d Normalized() const {
    const double r = std::sqrt(x * x + y * y + z * z);
    return {x / r, y / r, z / r};
  }
};

struct mat3d {
  double a[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double& operator()(int i, int j) { return a[i][j]; }
  double operator()(int i, int j) const { return a[i][j]; }
  mat3d operator*(const mat3d& m) const {
    mat3d r;
    for (int i = 0; i < 9; ++i) {
      r.a[i / 3][i % 3] = a[i / 3][0] * m(0, i % 3) + a[i / 3][1] * m(1, i % 3) + a[i / 3][2] * m(2, i % 3);
    }
    return r;
  }
  mat3d operator*(double f) const { return with(mat3d(), f, 0); }
  mat3d operator+(const mat3d& m) const { return with(m, 1, 1); }
  mat3d operator-(const mat3d& m) const { return with(m, 1, -1); }
  mat3d with(const mat3d& m, double f, double g) const {
    mat3d r;
    for (int i = 0; i < 9; ++i) r.a[i / 3][i % 3] = f * a[i / 3][i % 3] + g * m(i / 3, i % 3);
    return r;
  }
  double det() const {
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
           a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
  }
  mat3d inverse() const {
    mat3d b;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const int p = (j + 1) % 3, q = (j + 2) % 3, r = (i + 1) % 3, s = (i + 2) % 3;
        b.a[i][j] = (a[p][r] * a[q][s] - a[p][s] * a[q][r]) / det();
      }
    }
    return b;
  }
};
inline vec3d operator*(const mat3d& m, const vec3d& v) {
  return {m(0, 0) * v.x + m(0, 1) * v.y + m(0, 2) * v.z, m(1, 0) * v.x + m(1, 1) * v.y + m(1, 2) * v.z,
          m(2, 0) * v.x + m(2, 1) * v.y + m(2, 2) * v.z};
}

inline mat3d operator&(const vec3d& u, const vec3d& v) {
  mat3d r;
  const double a[3] = {u.x, u.y, u.z}, b[3] = {v.x, v.y, v.z};
  for (int i = 0; i < 9; ++i) r.a[i / 3][i % 3] = a[i / 3] * b[i % 3];
  return r;
}

struct mat3ds {
  double s[3][3];
  mat3ds() : mat3ds(0, 0, 0, 0, 0, 0) {}
  mat3ds(double xx, double yy, double zz, double xy, double yz, double xz)
      : s{{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}} {}
  double operator()(int i, int j) const { return s[i][j]; }
};

struct tens4ds {
  double d[6][6];
};

struct tens4dmm {
  double d[6][6];
  tens4dmm(const tens4ds& c) {  // NOLINT: as FEBio's
    for (int i = 0; i < 36; ++i) d[i / 6][i % 6] = c.d[i / 6][i % 6];
  }
  explicit tens4dmm(double x) {
    for (auto& row : d) {
      for (double& y : row) y = x;
    }
  }
  static int place(int i, int j) {
    const int m[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
    return m[i][j];
  }
  double& operator()(int i, int j, int k, int l) { return d[place(i, j)][place(k, l)]; }
  double operator()(int i, int j, int k, int l) const { return d[place(i, j)][place(k, l)]; }
  tens4dmm operator*(double f) const {
    tens4dmm r = *this;
    for (auto& row : r.d) {
      for (double& y : row) y *= f;
    }
    return r;
  }
  // F F F F : this
  tens4dmm pp(const mat3d& F) const {
    tens4dmm r(0.0);
    for (int n = 0; n < 6561; ++n) {
      int index[8], rest = n;
      for (int& i : index) i = rest % 3, rest /= 3;
      const int i = index[0], j = index[1], k = index[2], l = index[3];
      if (i <= j && k <= l) {
        r(i, j, k, l) += F(i, index[4]) * F(j, index[5]) * F(k, index[6]) * F(l, index[7]) *
                         (*this)(index[4], index[5], index[6], index[7]);
      }
    }
    return r;
  }
  tens4ds supersymm() const {
    tens4ds c;
    for (int i = 0; i < 36; ++i) c.d[i / 6][i % 6] = (d[i / 6][i % 6] + d[i % 6][i / 6]) / 2;
    return c;
  }
};

struct FETimeInfo {
  double timeIncrement = 0;
};

// Writes numbers, or reads what was written.
class DumpStream {
 public:
  bool loading = false;
  std::vector<double> numbers;
  std::size_t next = 0;
  DumpStream& operator&(double& x) {
    if (!loading) {
      numbers.push_back(x);
    } else {
      x = numbers.at(next++);
    }
    return *this;
  }
};

class FEMaterialPointData {
 public:
  explicit FEMaterialPointData(FEMaterialPointData* next = nullptr) : m_pNext(next) {}
  FEMaterialPointData(const FEMaterialPointData& other) = default;
  virtual ~FEMaterialPointData() { delete m_pNext; }
  template <class T>
  T* ExtractData() {
    for (FEMaterialPointData* d = this; d; d = d->m_pNext) {
      if (T* found = dynamic_cast<T*>(d)) return found;
    }
    return nullptr;
  }
  virtual void Init() {
    if (m_pNext) m_pNext->Init();
  }
  virtual void Update(const FETimeInfo& time) {
    if (m_pNext) m_pNext->Update(time);
  }
  virtual FEMaterialPointData* Copy() { return nullptr; }
  virtual void Serialize(DumpStream& stream) {
    if (m_pNext) m_pNext->Serialize(stream);
  }
  FEMaterialPointData* m_pNext;
};

class FEElasticMaterialPoint : public FEMaterialPointData {
 public:
  mat3d m_F, m_L;
  double m_J = 1;
  mat3ds m_s;
  mat3ds pull_back(const mat3ds& s) const {  // J F^-1 s F^-T
    const mat3d I = m_F.inverse();
    mat3d t, r;
    for (int i = 0; i < 9; ++i) t(i / 3, i % 3) = s(i / 3, i % 3);
    t = I * t;
    for (int i = 0; i < 9; ++i) {
      r(i / 3, i % 3) = 0;
      for (int k = 0; k < 3; ++k) r(i / 3, i % 3) += m_J * t(i / 3, k) * I(i % 3, k);
    }
    return mat3ds(r(0, 0), r(1, 1), r(2, 2), r(0, 1), r(1, 2), r(0, 2));
  }
  FEMaterialPointData* Copy() override { return new FEElasticMaterialPoint(*this); }
};

class FEMaterialPoint {
 public:
  explicit FEMaterialPoint(FEMaterialPointData* data) : data_(data) { data_->Init(); }
  template <class T>
  T* ExtractData() const {
    return data_->ExtractData<T>();
  }
  void Update(const FETimeInfo& time) { data_->Update(time); }
  void Serialize(DumpStream& stream) { data_->Serialize(stream); }

 private:
  std::unique_ptr<FEMaterialPointData> data_;
};

enum Matrix_Type { REAL_UNSYMMETRIC, REAL_SYMMETRIC };
struct FESolver {
  int m_msymm = REAL_UNSYMMETRIC;  // <symmetric_stiffness>
};
struct FEAnalysis {
  FESolver solver;
  FESolver* GetFESolver() { return &solver; }
};

class FEElasticMaterial;
struct FEModel {
  FEAnalysis step;
  FEAnalysis* GetCurrentStep() { return &step; }
  double increment = 0;
  mat3d axes;
  vec3d fibre{1, 0, 0};
  std::map<std::string, double> parameters;             // as a user gives them
  std::function<FEElasticMaterial*(FEModel*)> elastic;  // likewise
  std::string errors;
};

struct FEParamDouble {
  double value = 0;
  FEParamDouble& operator=(double x) {
    value = x;
    return *this;
  }
  double operator()(const FEMaterialPoint&) const { return is_map ? at_points : value; }
  bool is_map = false;
  double at_points = 0;
  bool isConst() const { return !is_map; }
  double constValue() const { return value; }
};

class FEVec3dValuator {
 public:
  explicit FEVec3dValuator(FEModel* model) : model_(model) {}
  vec3d unitVector(const FEMaterialPoint&) const { return model_->fibre.Normalized(); }

 private:
  FEModel* model_;
};

class FEMat3dValuator;  // <mat_axis>
struct FEProperty {
  enum { Required, Optional };
  FEProperty* SetFlags(unsigned) { return this; }
};

class FECoreBase {
 public:
  explicit FECoreBase(FEModel* model) : model_(model) {}
  virtual ~FECoreBase() = default;
  FEModel* GetFEModel() { return model_; }
  std::string GetName() const { return "muscle"; }
  static int superClassID() { return 1; }
  static const char* BaseClassName() { return "base"; }
  virtual const char* GetTypeStr() { return "of a test"; }
  virtual bool Init() { return true; }

 protected:
  void AddParameter(FEParamDouble& parameter, const char* name) {
    const auto given = model_->parameters.find(name);
    if (given != model_->parameters.end()) parameter = given->second;
  }
  struct Range {
    int from, to;
  };
  void AddParameter(int& parameter, Range range, const char* name) {
    const auto given = model_->parameters.find(name);
    if (given != model_->parameters.end()) parameter = static_cast<int>(given->second);
    if (parameter < range.from || parameter > range.to) throw std::out_of_range(name);
  }
  FEProperty* add_property(FEVec3dValuator*& property, const char*) {
    made_.push_back(std::make_shared<FEVec3dValuator>(model_));
    property = static_cast<FEVec3dValuator*>(made_.back().get());
    return &property_;
  }
  FEProperty* add_property(FEMat3dValuator*&, const char* name) {
    has_axes = std::string(name) == "mat_axis";
    return &property_;
  }
  FEProperty* add_property(FEElasticMaterial*& property, const char*);
  bool has_axes = false;
  FEProperty property_;
  FEModel* model_;
  std::vector<std::shared_ptr<void>> made_;  // its properties
};

#define DECLARE_FECORE_CLASS() \
 public:                       \
  void BuildParamList() override
#define BEGIN_FECORE_CLASS(Class, Base) \
  void Class::BuildParamList() {        \
    Base::BuildParamList();
#define END_FECORE_CLASS() }
#define ADD_PARAMETER(...) AddParameter(__VA_ARGS__)
#define ADD_PROPERTY(property, name) add_property(property, name)
#define FE_RANGE_CLOSED(from, to) (Range{from, to})
#define feLogError(...)                            \
  do {                                             \
    char line[1000];                               \
    std::snprintf(line, sizeof line, __VA_ARGS__); \
    GetFEModel()->errors = line;                   \
  } while (false)

class FEElasticMaterial : public FECoreBase {
 public:
  using FECoreBase::FECoreBase;
  virtual FEMaterialPointData* CreateMaterialPointData() { return new FEElasticMaterialPoint; }
  virtual mat3ds Stress(FEMaterialPoint&) = 0;
  virtual tens4ds Tangent(FEMaterialPoint&) = 0;
  virtual tens4dmm SecantTangent(FEMaterialPoint&, bool /*in_material_frame*/ = false) {
    return tens4dmm(0.0);
  }
  virtual bool UseSecantTangent() { return false; }
  tens4dmm SolidTangent(FEMaterialPoint& p) { return UseSecantTangent() ? SecantTangent(p) : Tangent(p); }
  virtual mat3ds SecantStress(FEMaterialPoint&, bool /*second_piola*/ = false) { return {}; }
  virtual double StrainEnergyDensity(FEMaterialPoint&) { return 0; }
  virtual void UpdateSpecializedMaterialPoints(FEMaterialPoint&, const FETimeInfo&) {}
  virtual void BuildParamList() {}

 protected:
  double CurrentTimeIncrement() const { return model_->increment; }
  // A material that has no <mat_axis> turns nothing.
  mat3d GetLocalCS(const FEMaterialPoint&) const { return has_axes ? model_->axes : mat3d(); }
  FEMat3dValuator* m_Q = nullptr;
};

inline FEProperty* FECoreBase::add_property(FEElasticMaterial*& property, const char*) {
  const std::shared_ptr<FEElasticMaterial> elastic(model_->elastic(model_));
  elastic->BuildParamList();
  made_.push_back(elastic);
  property = elastic.get();
  return &property_;
}

struct FEElement {
  std::vector<FEMaterialPoint*> points;
  int GaussPoints() const { return static_cast<int>(points.size()); }
  FEMaterialPoint* GetMaterialPoint(int i) { return points[static_cast<std::size_t>(i)]; }
};
struct FEDomain {
  FEElement element;
};
struct FEDataStream {
  std::vector<double> numbers;
};
enum { PLT_FLOAT, FMT_ITEM };
class FEPlotDomainData : public FECoreBase {
 public:
  FEPlotDomainData(FEModel* model, int, int) : FECoreBase(model) {}
  virtual bool Save(FEDomain&, FEDataStream&) = 0;
};
class FELogElemData : public FECoreBase {
 public:
  using FECoreBase::FECoreBase;
  virtual double value(FEElement&) = 0;
};
template <class T>
void writeAverageElementValue(FEDomain& domain, FEDataStream& stream,
                              std::function<T(const FEMaterialPoint&)> f) {
  T sum = 0;
  for (FEMaterialPoint* p : domain.element.points) sum += f(*p);
  stream.numbers.push_back(sum / domain.element.GaussPoints());
}

class FECoreKernel {
 public:
  static FECoreKernel& GetInstance() { return *instance(); }
  static void SetInstance(FECoreKernel* kernel) { instance() = kernel; }
  std::multimap<std::string, std::function<FECoreBase*(FEModel*)>> classes;
  // The class of this name of a kind, with its parameters read.
  template <class Base>
  std::unique_ptr<Base> create(const std::string& name, FEModel* model) {
    for (auto [c, end] = classes.equal_range(name); c != end; ++c) {
      FECoreBase* made = c->second(model);
      if (Base* found = dynamic_cast<Base*>(made)) return std::unique_ptr<Base>(found);
      delete made;
    }
    return nullptr;
  }

 private:
  static FECoreKernel*& instance() {
    static FECoreKernel* kernel = nullptr;
    return kernel;
  }
};

template <class T>
struct FERegisterClass_T {
  FERegisterClass_T(int, const char*, const char*, const char* name) {
    FECoreKernel::GetInstance().classes.emplace(name,
                                                [](FEModel* model) -> FECoreBase* { return new T(model); });
  }
};
#define REGISTER_FECORE_CLASS(Class, name)                                                                  \
  static FERegisterClass_T<Class> registered_##Class(Class::superClassID(), #Class, Class::BaseClassName(), \
                                                     name)

#endif
