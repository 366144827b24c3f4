/* MuJoCo's algorithms behind plain C functions, each with the kinematics it needs and nothing else. */
#include <mujoco/mujoco.h>
#include <string.h>

static mjModel *model;
static mjData *data;
static mjtNum *result;

int bench_mujoco_open(const char *path)
{
    model = mj_loadModel(path, NULL);
    data = model ? mj_makeData(model) : NULL;
    result = data ? mju_malloc(sizeof(mjtNum) * (size_t)(model->nv + 1)) : NULL;
    return result == NULL;
}

static void set(const double *q, const double *v)
{
    memcpy(data->qpos, q, sizeof(double) * (size_t)model->nq);
    if (v) {
        memcpy(data->qvel, v, sizeof(double) * (size_t)model->nv);
    }
    mj_kinematics(model, data);
    mj_comPos(model, data);
    if (v) {
        mj_comVel(model, data);
    }
}

void bench_mujoco_mass_matrix(const double *q)
{
    set(q, NULL);
    mj_makeM(model, data);
}

void bench_mujoco_bias_force(const double *q, const double *v)
{
    set(q, v);
    mj_rne(model, data, 0, result);
}

void bench_mujoco_inverse_dynamics(const double *q, const double *v, const double *a)
{
    memcpy(data->qacc, a, sizeof(double) * (size_t)model->nv);
    set(q, v);
    mj_rne(model, data, 1, result);
    for (int i = 0; i < (int)model->nv; ++i) {
        result[i] += model->dof_armature[i] * a[i];
    }
}

void bench_mujoco_forward_dynamics(const double *q, const double *v, const double *tau)
{
    set(q, v);
    mj_makeM(model, data);
    mj_factorM(model, data);
    mj_rne(model, data, 0, result);
    for (int i = 0; i < (int)model->nv; ++i) {
        result[i] = tau[i] - result[i];
    }
    mj_solveM(model, data, result, result, 1);
}

void bench_mujoco_fetch(const char *function, double *out)
{
    if (!strcmp(function, "mass_matrix")) {
        mj_fullM(model, data, out);
    } else {
        memcpy(out, result, sizeof(double) * (size_t)model->nv);
    }
}
