// A stand-in for the few classes of FEBio 4 that examples/febio/plugin.cpp uses, by FEBio's names and
// conventions: order xx yy zz xy yz xz in the constructor of mat3ds, a modulus with minor symmetries, states
// that are saved and restored by one and the same function.
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
  double x = 0, y = 0, z = 0;
  vec3d Normalized() const {
    const double r = std::sqrt(x * x + y * y + z * z);
    return {x / r, y / r, z / r};
  }
};

struct mat3d {
  double a[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double& operator()(int i, int j) { return a[i][j]; }
  double operator()(int i, int j) const { return a[i][j]; }
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

struct mat3ds {
  double s[3][3];
  mat3ds(double xx, double yy, double zz, double xy, double yz, double xz)
      : s{{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}} {}
  double operator()(int i, int j) const { return s[i][j]; }
};

struct tens4ds {};

struct tens4dmm {
  double d[6][6];
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
  tens4ds supersymm() const { return {}; }
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
  mat3d m_F;
  double m_J = 1;
  FEMaterialPointData* Copy() override { return new FEElasticMaterialPoint(*this); }
};

class FEMaterialPoint {
 public:
  explicit FEMaterialPoint(FEMaterialPointData* data) : data_(data) { data_->Init(); }
  template <class T>
  T* ExtractData() const {
    for (FEMaterialPointData* d = data_.get(); d; d = d->m_pNext) {
      if (T* found = dynamic_cast<T*>(d)) return found;
    }
    return nullptr;
  }
  void Update(const FETimeInfo& time) { data_->Update(time); }
  void Serialize(DumpStream& stream) { data_->Serialize(stream); }

 private:
  std::unique_ptr<FEMaterialPointData> data_;
};

struct FEModel {
  double increment = 0;
  mat3d axes;
  vec3d fibre{1, 0, 0};
  std::map<std::string, double> parameters;  // as a user gives them
  std::string errors;
};

struct FEParamDouble {
  double value = 0;
  FEParamDouble& operator=(double x) {
    value = x;
    return *this;
  }
  double operator()(const FEMaterialPoint&) const { return value; }
};

class FEVec3dValuator {
 public:
  explicit FEVec3dValuator(FEModel* model) : model_(model) {}
  vec3d unitVector(const FEMaterialPoint&) const { return model_->fibre.Normalized(); }

 private:
  FEModel* model_;
};

class FECoreBase {
 public:
  explicit FECoreBase(FEModel* model) : model_(model) {}
  virtual ~FECoreBase() = default;
  FEModel* GetFEModel() { return model_; }
  std::string GetName() const { return "muscle"; }
  static int superClassID() { return 1; }
  static const char* BaseClassName() { return "base"; }

 protected:
  void take(const char* name, FEParamDouble& parameter, double least, bool with_least) {
    const auto given = model_->parameters.find(name);
    if (given != model_->parameters.end()) parameter = given->second;
    if (!(parameter.value > least || (with_least && parameter.value >= least))) throw std::out_of_range(name);
  }
  FEModel* model_;
};

#define DECLARE_FECORE_CLASS() \
 public:                       \
  void BuildParamList()
#define BEGIN_FECORE_CLASS(Class, Base) void Class::BuildParamList() {
#define END_FECORE_CLASS() }
#define ADD_PARAMETER(parameter, range, name) take(name, parameter, range)
#define ADD_PROPERTY(property, name) property = new FEVec3dValuator(model_)
#define FE_RANGE_GREATER(x) x, false
#define FE_RANGE_GREATER_OR_EQUAL(x) x, true
#define feLogError(...)                            \
  do {                                             \
    char line[400];                                \
    std::snprintf(line, sizeof line, __VA_ARGS__); \
    GetFEModel()->errors = line;                   \
  } while (false)

class FEElasticMaterial : public FECoreBase {
 public:
  using FECoreBase::FECoreBase;
  virtual FEMaterialPointData* CreateMaterialPointData() { return new FEElasticMaterialPoint; }
  virtual mat3ds Stress(FEMaterialPoint&) = 0;
  virtual tens4ds Tangent(FEMaterialPoint&) = 0;
  virtual tens4dmm SecantTangent(FEMaterialPoint&, bool in_material_frame = false) = 0;
  virtual bool UseSecantTangent() { return false; }
  virtual double StrainEnergyDensity(FEMaterialPoint&) = 0;
  virtual void BuildParamList() {}

 protected:
  double CurrentTimeIncrement() const { return model_->increment; }
  mat3d GetLocalCS(const FEMaterialPoint&) const { return model_->axes; }
};

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
