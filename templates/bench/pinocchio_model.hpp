// A Pinocchio model of any scalar, read from a text file that symgen wrote: what all Pinocchio peers start from.
#pragma once

#include <fstream>
#include <stdexcept>
#include <string>

#include "pinocchio/multibody.hpp"
#include "pinocchio/multibody/joint.hpp"
#include "pinocchio/spatial.hpp"

// Joints in the order in which they are added; angles, axes and places as the URDF reader would give them: a joint about
// a coordinate axis gets the joint model of that axis.
template <class Model>
typename Model::JointModel joint_model(const std::string &kind, const Eigen::Vector3d &axis, double pitch)
{
    using Scalar = typename Model::Scalar;
    constexpr int Options = Model::Options;
    const typename Model::Vector3 u = axis.template cast<Scalar>();
    if (kind == "RX") return pinocchio::JointModelRevoluteTpl<Scalar, Options, 0>();
    if (kind == "RY") return pinocchio::JointModelRevoluteTpl<Scalar, Options, 1>();
    if (kind == "RZ") return pinocchio::JointModelRevoluteTpl<Scalar, Options, 2>();
    if (kind == "RU") return pinocchio::JointModelRevoluteUnalignedTpl<Scalar, Options>(u);
    if (kind == "PX") return pinocchio::JointModelPrismaticTpl<Scalar, Options, 0>();
    if (kind == "PY") return pinocchio::JointModelPrismaticTpl<Scalar, Options, 1>();
    if (kind == "PZ") return pinocchio::JointModelPrismaticTpl<Scalar, Options, 2>();
    if (kind == "PU") return pinocchio::JointModelPrismaticUnalignedTpl<Scalar, Options>(u);
    if (kind == "FF") return pinocchio::JointModelFreeFlyerTpl<Scalar, Options>();
    if (kind == "S") return pinocchio::JointModelSphericalTpl<Scalar, Options>();
#ifndef BENCH_FEW_JOINTS
    if (kind == "HU") return pinocchio::JointModelHelicalUnalignedTpl<Scalar, Options>(u, Scalar(pitch));
#endif
    (void)pitch;
    throw std::runtime_error("no joint model " + kind);
}

template <class Vector>
void read_into(std::istream &file, Vector &values)
{
    for (Eigen::Index i = 0; i < values.size(); ++i) file >> values[i];
}

template <class Model>
Model read_model(const char *path)
{
    using Scalar = typename Model::Scalar;
    using SE3 = typename Model::SE3;
    using Inertia = typename Model::Inertia;
    std::ifstream file(path);
    Model model;
    int joints = 0;
    Eigen::Vector3d gravity;
    file >> joints;
    read_into(file, gravity);
    model.gravity.linear(gravity.template cast<Scalar>());
    for (int k = 0; k < joints; ++k) {
        std::string kind;
        std::size_t parent = 0;
        double pitch = 0, armature = 0, mass = 0;
        Eigen::Vector3d axis, place, centre;
        Eigen::Matrix<double, 9, 1> turn, moments;
        file >> kind >> parent >> pitch >> armature >> mass;
        read_into(file, axis);
        read_into(file, place);
        read_into(file, centre);
        read_into(file, turn);
        read_into(file, moments);
        if (!file) throw std::runtime_error(std::string("cannot read ") + path);
        using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
        const Eigen::Matrix3d R = Eigen::Map<const RowMajor>(turn.data());
        const Eigen::Matrix3d I = Eigen::Map<const RowMajor>(moments.data());
        const SE3 mount(R.template cast<Scalar>(), place.template cast<Scalar>());
        const auto joint = joint_model<Model>(kind, axis, pitch);
        const auto index = model.addJoint(parent, joint, mount, "joint" + std::to_string(k));
        const Eigen::Matrix<Scalar, 3, 3> inertia = I.template cast<Scalar>();
        model.appendBodyToJoint(index, Inertia(Scalar(mass), centre.template cast<Scalar>(), inertia), SE3::Identity());
        const int nv = model.joints[index].nv();
        model.armature.segment(model.joints[index].idx_v(), nv).setConstant(Scalar(armature));
    }
    return model;
}
