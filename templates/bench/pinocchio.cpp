// Pinocchio's algorithms behind plain C functions. Each leaves its result in Pinocchio's own Data, as its users have it;
// pinocchio_fetch copies it out, row-major and full, to be compared.
#include "pinocchio_model.hpp"

#include "pinocchio/algorithm/aba-derivatives.hpp"
#include "pinocchio/algorithm/aba.hpp"
#include "pinocchio/algorithm/crba.hpp"
#include "pinocchio/algorithm/rnea-derivatives.hpp"
#include "pinocchio/algorithm/rnea.hpp"

namespace {
using Vector = Eigen::Map<const Eigen::VectorXd>;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
pinocchio::Model model;
pinocchio::Data data;

Vector positions(const double *q) { return Vector(q, model.nq); }
Vector rates(const double *v) { return Vector(v, model.nv); }

template <class Matrix>
double *copy(const Matrix &matrix, double *out)
{
    Eigen::Map<RowMajor>(out, matrix.rows(), matrix.cols()) = matrix;
    return out + matrix.size();
}

template <class Matrix>
void copy_upper(const Matrix &matrix, double *out)
{
    const Eigen::MatrixXd full = matrix.template selfadjointView<Eigen::Upper>();
    copy(full, out);
}
} // namespace

extern "C" {
int pinocchio_open(const char *path)
{
    try {
        model = read_model<pinocchio::Model>(path);
        data = pinocchio::Data(model);
        return 0;
    } catch (const std::exception &) {
        return 1;
    }
}

void pinocchio_mass_matrix(const double *q) { pinocchio::crba(model, data, positions(q)); }

void pinocchio_bias_force(const double *q, const double *v)
{
    pinocchio::nonLinearEffects(model, data, positions(q), rates(v));
}

void pinocchio_inverse_dynamics(const double *q, const double *v, const double *a)
{
    pinocchio::rnea(model, data, positions(q), rates(v), rates(a));
}

void pinocchio_forward_dynamics(const double *q, const double *v, const double *tau)
{
    pinocchio::aba(model, data, positions(q), rates(v), rates(tau));
}

void pinocchio_mass_matrix_inverse(const double *q) { pinocchio::computeMinverse(model, data, positions(q)); }

void pinocchio_inverse_dynamics_derivatives(const double *q, const double *v, const double *a)
{
    pinocchio::computeRNEADerivatives(model, data, positions(q), rates(v), rates(a));
}

void pinocchio_forward_dynamics_derivatives(const double *q, const double *v, const double *tau)
{
    pinocchio::computeABADerivatives(model, data, positions(q), rates(v), rates(tau));
}

void pinocchio_fetch(const char *function, double *out)
{
    const std::string name(function);
    if (name == "mass_matrix") copy_upper(data.M, out);
    if (name == "bias_force") copy(data.nle, out);
    if (name == "inverse_dynamics") copy(data.tau, out);
    if (name == "forward_dynamics") copy(data.ddq, out);
    if (name == "mass_matrix_inverse") copy_upper(data.Minv, out);
    if (name == "inverse_dynamics_derivatives") copy(data.dtau_dv, copy(data.dtau_dq, out));
    if (name == "forward_dynamics_derivatives") copy(data.Minv, copy(data.ddq_dv, copy(data.ddq_dq, out)));
}
}
