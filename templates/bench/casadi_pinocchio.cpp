// Writes C for Pinocchio's algorithms by CasADi: casadi_pinocchio MODEL FOLDER FUNCTION…
// Each function becomes FOLDER/pincasadi_FUNCTION.c with CasADi's C interface and that name, inputs q, v, u; a
// line on stdout says the seconds that took.
#include "pinocchio/autodiff/casadi.hpp"

#include "pinocchio_rows.hpp"

#include <algorithm>
#include <chrono>
#include <iostream>

using Scalar = casadi::SX;

static VectorOf<Scalar> entries(const casadi::SX &x)
{
    VectorOf<Scalar> found(x.numel());
    for (casadi_int i = 0; i < x.numel(); ++i) found[i] = x(i);
    return found;
}

// Additions, multiplications, divisions and roots, as symgen counts its own.
static long operations(const casadi::Function &function)
{
    const std::vector<casadi_int> counted = {casadi::OP_ADD, casadi::OP_SUB, casadi::OP_MUL,   casadi::OP_DIV, casadi::OP_NEG,
                                             casadi::OP_SQ,  casadi::OP_INV, casadi::OP_TWICE, casadi::OP_SQRT};
    long found = 0;
    for (casadi_int k = 0; k < function.n_instructions(); ++k)
        found += std::count(counted.begin(), counted.end(), function.instruction_id(k));
    return found;
}

static void write(const std::string &name, const ModelOf<Scalar> &model, const std::string &folder)
{
    const auto q = casadi::SX::sym("q", model.nq), v = casadi::SX::sym("v", model.nv), u = casadi::SX::sym("u", model.nv);
    const casadi::SX y = casadi::SX::vertcat(rows_of<Scalar>(name, model, entries(q), entries(v), entries(u)));
    const std::vector<casadi::SX> shared = casadi::SX::cse(std::vector<casadi::SX>{casadi::SX::densify(y)});
    const bool still = name == "mass_matrix" || name == "mass_matrix_inverse";
    std::vector<casadi::SX> inputs = {q};
    if (!still) inputs.push_back(v);
    if (!still && name != "bias_force") inputs.push_back(u);
    const casadi::Function function("pincasadi_" + name, inputs, shared);
    std::ofstream(folder + "/" + name + ".operations") << operations(function) << "\n";
    casadi::CodeGenerator generator(function.name() + ".c", {{"with_header", false}});
    generator.add(function);
    generator.generate(folder + "/");
}

int main(int argc, char **argv)
{
    try {
        const auto model = read_model<ModelOf<Scalar>>(argv[1]);
        for (int k = 3; k < argc; ++k) {
            const auto started = std::chrono::steady_clock::now();
            write(argv[k], model, argv[2]);
            const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - started;
            std::cout << argv[k] << " " << taken.count() << std::endl;
        }
        return argc > 3 ? 0 : 1;
    } catch (const std::exception &error) {
        std::cerr << error.what() << std::endl;
        return 1;
    }
}
