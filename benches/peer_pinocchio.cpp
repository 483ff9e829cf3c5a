// Pinocchio without Python: the loop of `cargo bench --bench kinematics`, 1000 configurations of the KUKA arm a pass.
//
// The wheel `pin` carries the library and its headers (`pip install pin cmeel-eigen`); P is its cmeel.prefix:
//   g++ -O3 -DNDEBUG -std=c++17 -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS -DBOOST_MPL_LIMIT_LIST_SIZE=30
//       -DBOOST_MPL_LIMIT_VECTOR_SIZE=30 peer_pinocchio.cpp -I$P/include -I$P/include/eigen3 -L$P/lib
//       -lpinocchio_default -Wl,-rpath,$P/lib -o peer
// The headers are templates, so the loops are compiled here, with the flags given here (tried: -march=native gains 5 %).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>
#include "pinocchio/multibody.hpp"
#include "pinocchio/algorithm/frames.hpp"
#include "pinocchio/algorithm/jacobian.hpp"
#include "pinocchio/algorithm/kinematics.hpp"

using namespace pinocchio;
static SE3 rot(char axis, double deg) {
  const double r = deg * M_PI / 180;
  const Eigen::Vector3d a = axis == 'x' ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
  return SE3(Eigen::AngleAxisd(r, a).toRotationMatrix(), Eigen::Vector3d::Zero());
}

template <class F> static void bench(const char *name, const std::vector<Eigen::VectorXd> &qs, F f) {
  std::vector<double> ns;
  for (int k = 0; k < 201; ++k) {
    const auto t = std::chrono::steady_clock::now();
    for (const auto &q : qs) f(q);
    ns.push_back(std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - t).count() / qs.size());
  }
  std::nth_element(ns.begin(), ns.begin() + ns.size() / 2, ns.end());
  std::printf("%-50s %7.1f ns\n", name, ns[ns.size() / 2]);
}

int main() {
  // theta_deg, d, a (m), alpha_deg, direction: configs/kuka-kr120-r2500-pro.yaml
  const double dh[6][5] = {{0, .675, .350, -90, -1}, {0, 0, 1.150, 0, 1}, {-90, 0, -.041, -90, 1},
                           {0, 1.0, 0, 90, -1}, {0, 0, 0, -90, 1}, {180, .215, 0, 0, -1}};
  Model model;
  JointIndex parent = 0;
  SE3 place = SE3::Identity();
  for (int i = 0; i < 6; ++i) {
    // a turned joint is a turned frame around the same fast joint type: Rx(180) Rz(q) Rx(180) = Rz(-q)
    const SE3 flip = dh[i][4] < 0 ? rot('x', 180) : SE3::Identity();
    parent = model.addJoint(parent, JointModelRZ(), place * rot('z', dh[i][0]) * flip, "j" + std::to_string(i));
    place = flip * SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(dh[i][2], 0, dh[i][1])) * rot('x', dh[i][3]);
  }
  const SE3 tool(Eigen::Matrix3d::Identity(), Eigen::Vector3d(.156, 0, .063));
  const FrameIndex tcp = model.addFrame(Frame("tcp", parent, 0, place * tool, OP_FRAME));
  Data data(model);
  std::vector<Eigen::VectorXd> qs(1000, Eigen::VectorXd(6));
  for (int i = 0; i < 1000; ++i)
    for (int k = 0; k < 6; ++k) qs[i][k] = std::sin((i * 7 + k * 13) * 0.017);
  Data::Matrix6x jac = Data::Matrix6x::Zero(6, 6);
  framesForwardKinematics(model, data, qs[1]);
  std::printf("TCP of configuration 1: %.12f %.12f %.12f m\n", data.oMf[tcp].translation()[0],
              data.oMf[tcp].translation()[1], data.oMf[tcp].translation()[2]);
  bench("forwardKinematics + frame", qs, [&](const auto &q) { forwardKinematics(model, data, q); updateFramePlacement(model, data, tcp); });
  bench("computeJointJacobians", qs, [&](const auto &q) { computeJointJacobians(model, data, q); });
  bench("computeFrameJacobian", qs, [&](const auto &q) { computeFrameJacobian(model, data, q, tcp, LOCAL_WORLD_ALIGNED, jac); });
}
