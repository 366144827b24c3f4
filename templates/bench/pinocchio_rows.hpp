// Pinocchio's algorithms over a scalar that records what is computed, for the peers that generate code from it.
#pragma once

#define BENCH_FEW_JOINTS
#include "pinocchio_model.hpp"

#include <vector>

#include "pinocchio/algorithm/aba-derivatives.hpp"
#include "pinocchio/algorithm/aba.hpp"
#include "pinocchio/algorithm/crba.hpp"
#include "pinocchio/algorithm/rnea-derivatives.hpp"
#include "pinocchio/algorithm/rnea.hpp"

// Only the joints that are used (mimic ones Pinocchio asks for by itself): with every joint of Pinocchio's the compiler
// needs several times the memory.
template <class S, int O>
struct FewJoints {
    using Scalar = S;
    static constexpr int Options = O;
    using JointModelVariant = boost::variant<
        pinocchio::JointModelRevoluteTpl<S, O, 0>, pinocchio::JointModelRevoluteTpl<S, O, 1>,
        pinocchio::JointModelRevoluteTpl<S, O, 2>, pinocchio::JointModelRevoluteUnalignedTpl<S, O>,
        pinocchio::JointModelPrismaticTpl<S, O, 0>, pinocchio::JointModelPrismaticTpl<S, O, 1>,
        pinocchio::JointModelPrismaticTpl<S, O, 2>, pinocchio::JointModelPrismaticUnalignedTpl<S, O>,
        pinocchio::JointModelSphericalTpl<S, O>, pinocchio::JointModelFreeFlyerTpl<S, O>,
        boost::recursive_wrapper<pinocchio::JointModelMimicTpl<S, O, ::FewJoints>>>;
    using JointDataVariant = boost::variant<
        pinocchio::JointDataRevoluteTpl<S, O, 0>, pinocchio::JointDataRevoluteTpl<S, O, 1>,
        pinocchio::JointDataRevoluteTpl<S, O, 2>, pinocchio::JointDataRevoluteUnalignedTpl<S, O>,
        pinocchio::JointDataPrismaticTpl<S, O, 0>, pinocchio::JointDataPrismaticTpl<S, O, 1>,
        pinocchio::JointDataPrismaticTpl<S, O, 2>, pinocchio::JointDataPrismaticUnalignedTpl<S, O>,
        pinocchio::JointDataSphericalTpl<S, O>, pinocchio::JointDataFreeFlyerTpl<S, O>,
        boost::recursive_wrapper<pinocchio::JointDataMimicTpl<S, O, ::FewJoints>>>;
};

template <class S>
using ModelOf = pinocchio::ModelTpl<S, 0, FewJoints>;
template <class S>
using VectorOf = Eigen::Matrix<S, Eigen::Dynamic, 1>;

// Entries row-major; symmetric matrices by their upper triangle, which is what Pinocchio computes.
template <class S, class Matrix>
void take(const Matrix &matrix, bool upper, std::vector<S> &out)
{
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
        for (Eigen::Index j = upper ? i : 0; j < matrix.cols(); ++j) out.push_back(matrix(i, j));
}

template <class S>
std::vector<S> rows_of(const std::string &name, const ModelOf<S> &model, const VectorOf<S> &q, const VectorOf<S> &v,
                       const VectorOf<S> &u)
{
    pinocchio::DataTpl<S, 0, FewJoints> data(model);
    std::vector<S> out;
    if (name == "mass_matrix") {
        pinocchio::crba(model, data, q);
        take(data.M, true, out);
    } else if (name == "bias_force") {
        take(pinocchio::nonLinearEffects(model, data, q, v), false, out);
    } else if (name == "inverse_dynamics") {
        take(pinocchio::rnea(model, data, q, v, u), false, out);
    } else if (name == "forward_dynamics") {
        take(pinocchio::aba(model, data, q, v, u), false, out);
    } else if (name == "mass_matrix_inverse") {
        pinocchio::computeMinverse(model, data, q);
        take(data.Minv, true, out);
    } else if (name == "inverse_dynamics_derivatives") {
        pinocchio::computeRNEADerivatives(model, data, q, v, u);
        take(data.dtau_dq, false, out);
        take(data.dtau_dv, false, out);
    } else if (name == "forward_dynamics_derivatives") {
        pinocchio::computeABADerivatives(model, data, q, v, u);
        take(data.ddq_dq, false, out);
        take(data.ddq_dv, false, out);
        take(data.Minv, false, out);
    } else {
        throw std::runtime_error("no function " + name);
    }
    return out;
}
