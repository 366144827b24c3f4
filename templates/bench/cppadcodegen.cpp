// Writes C for Pinocchio's algorithms by CppADCodeGen: cppadcodegen MODEL FOLDER FUNCTION…
// Each function becomes FOLDER/FUNCTION.c with `void cppadcodegen_FUNCTION(const double *x, double *y)`, x = [q v u];
// a line on stdout says the seconds that took.
#include "pinocchio/codegen/cppadcg.hpp"

#include "pinocchio_rows.hpp"

#include <chrono>
#include <iostream>

using Recorded = CppAD::cg::CG<double>;
using Scalar = CppAD::AD<Recorded>;

static std::size_t inputs_of(const std::string &name)
{
    if (name == "mass_matrix" || name == "mass_matrix_inverse") return 1;
    return name == "bias_force" ? 2 : 3;
}

static std::string source(const std::string &name, const ModelOf<Scalar> &model)
{
    const Eigen::Index nq = model.nq, nv = model.nv, parts = static_cast<Eigen::Index>(inputs_of(name));
    std::vector<Scalar> x(static_cast<std::size_t>(nq + (parts - 1) * nv), Scalar(0));
    for (Eigen::Index k = 0; k < model.njoints; ++k) // a quaternion must not be zero while it is recorded
        if (model.joints[static_cast<std::size_t>(k)].nq() > model.joints[static_cast<std::size_t>(k)].nv())
            x[static_cast<std::size_t>(model.joints[static_cast<std::size_t>(k)].idx_q() +
                                       model.joints[static_cast<std::size_t>(k)].nq() - 1)] = Scalar(1);
    CppAD::Independent(x);
    VectorOf<Scalar> q(nq), v(nv), u(nv);
    for (Eigen::Index i = 0; i < nq; ++i) q[i] = x[static_cast<std::size_t>(i)];
    for (Eigen::Index i = 0; i < nv; ++i) v[i] = parts > 1 ? x[static_cast<std::size_t>(nq + i)] : Scalar(0);
    for (Eigen::Index i = 0; i < nv; ++i) u[i] = parts > 2 ? x[static_cast<std::size_t>(nq + nv + i)] : Scalar(0);
    const std::vector<Scalar> y = rows_of<Scalar>(name, model, q, v, u);
    CppAD::ADFun<Recorded> function;
    function.Dependent(x, y);
    function.optimize("no_compare_op");

    CppAD::cg::CodeHandler<double> handler;
    std::vector<Recorded> independent(x.size());
    handler.makeVariables(independent);
    std::vector<Recorded> dependent = function.Forward(0, independent);
    CppAD::cg::LanguageC<double> language("double");
    CppAD::cg::LangCDefaultVariableNameGenerator<double> names("y", "x", "v");
    std::ostringstream body;
    handler.generateCode(body, language, dependent, names);
    std::ostringstream text;
    text << "#include <math.h>\n\nvoid cppadcodegen_" << name << "(const double *x, double *y)\n{\n    double v["
         << std::max<std::size_t>(1, handler.getTemporaryVariableCount()) << "];\n" << body.str() << "}\n";
    return text.str();
}

int main(int argc, char **argv)
{
    try {
        const auto model = read_model<ModelOf<Scalar>>(argv[1]);
        for (int k = 3; k < argc; ++k) {
            const auto started = std::chrono::steady_clock::now();
            const std::string text = source(argv[k], model);
            std::ofstream(std::string(argv[2]) + "/" + argv[k] + ".c") << text;
            const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - started;
            std::cout << argv[k] << " " << taken.count() << std::endl;
        }
        return argc > 3 ? 0 : 1;
    } catch (const std::exception &error) {
        std::cerr << error.what() << std::endl;
        return 1;
    }
}
