// A world simulated by the physics engine of Gazebo Sim, with no server about it:
//
//   gazebo-engine WORLD STEPS[,STEPS...] [MODEL::JOINT=SPEED ...]
//
// It does what the server's physics system does: libsdformat reads the world and the engine's plug-in builds it; meshes,
// of which the plug-in takes no notice in SDF, are loaded and attached to their links; joints are told their speeds,
// rad/s, before every step. After so many steps, and so many more, it prints of each model that can move the name, x y z,
// metres, and roll pitch yaw, radians.

#include <chrono>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <ignition/common/Mesh.hh>
#include <ignition/common/MeshManager.hh>
#include <ignition/math/eigen3/Conversions.hh>
#include <ignition/physics/ForwardStep.hh>
#include <ignition/physics/FrameSemantics.hh>
#include <ignition/physics/GetEntities.hh>
#include <ignition/physics/Joint.hh>
#include <ignition/physics/RequestEngine.hh>
#include <ignition/physics/config.hh>
#include <ignition/physics/mesh/MeshShape.hh>
#include <ignition/physics/sdf/ConstructCollision.hh>
#include <ignition/physics/sdf/ConstructJoint.hh>
#include <ignition/physics/sdf/ConstructLink.hh>
#include <ignition/physics/sdf/ConstructModel.hh>
#include <ignition/physics/sdf/ConstructWorld.hh>
#include <ignition/plugin/Loader.hh>
#include <sdf/sdf.hh>

namespace physics = ignition::physics;
using ignition::math::eigen3::convert;

struct Features : physics::FeatureList<
  physics::ForwardStep, physics::GetEntities, physics::LinkFrameSemantics, physics::SetJointVelocityCommandFeature,
  physics::mesh::AttachMeshShapeFeature,
  physics::sdf::ConstructSdfWorld, physics::sdf::ConstructSdfModel, physics::sdf::ConstructSdfLink,
  physics::sdf::ConstructSdfJoint, physics::sdf::ConstructSdfCollision> {};
using World = physics::World3dPtr<Features>;
using Joint = physics::Joint3dPtr<Features>;

const std::string PLUGIN = IGNITION_PHYSICS_ENGINE_INSTALL_DIR "/libignition-physics-dartsim-plugin.so";

physics::Engine3dPtr<Features> Engine()
{
  ignition::plugin::Loader loader;
  for (const auto &name : loader.LoadLib(PLUGIN))
    if (auto engine = physics::RequestEngine3d<Features>::From(loader.Instantiate(name)))
      return engine;
  throw std::runtime_error("no engine in " + PLUGIN);
}

void AttachMeshes(
  const World &simulated, const sdf::Model &model, const sdf::Link &link, const std::filesystem::path &folder)
{
  for (std::uint64_t i = 0; i < link.CollisionCount(); ++i)
  {
    const auto &collision = *link.CollisionByIndex(i);
    const auto *shape = collision.Geom()->MeshShape();
    if (!shape)
      continue;
    const auto path = (folder / shape->Uri()).string();
    const auto *mesh = ignition::common::MeshManager::Instance()->Load(path);
    if (!mesh)
      throw std::runtime_error("no mesh in " + path);
    simulated->GetModel(model.Name())->GetLink(link.Name())->AttachMeshShape(
      collision.Name(), *mesh, convert(collision.RawPose()), convert(shape->Scale()));
  }
}

std::pair<Joint, double> Turning(const World &simulated, const std::string &told)
{
  const auto colons = told.find("::"), equals = told.find('=');
  const auto model = simulated->GetModel(told.substr(0, colons));
  const auto joint = model ? model->GetJoint(told.substr(colons + 2, equals - colons - 2)) : nullptr;
  if (!joint)
    throw std::runtime_error("no joint for " + told);
  return {joint, std::stod(told.substr(equals + 1))};
}

void Step(const World &simulated, const std::vector<std::pair<Joint, double>> &turning, double seconds, int steps)
{
  using Duration = std::chrono::steady_clock::duration;
  physics::ForwardStep::Output output;
  physics::ForwardStep::State state;
  physics::ForwardStep::Input input;
  input.Get<Duration>() = std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
  for (int step = 0; step < steps; ++step)
  {
    for (const auto &[joint, speed] : turning)
      joint->SetVelocityCommand(0, speed);
    simulated->Step(output, state, input);
  }
}

void Print(const World &simulated, const sdf::World &world)
{
  for (std::uint64_t i = 0; i < world.ModelCount(); ++i)
  {
    const auto &model = *world.ModelByIndex(i);
    if (!model.Static())
      std::cout << model.Name() << ' '
                << convert(simulated->GetModel(model.Name())->GetLink(0)->FrameDataRelativeToWorld().pose) << '\n';
  }
}

void Run(const std::string &file, std::istringstream steps, const std::vector<std::string> &told)
{
  sdf::Root root;
  for (const auto &error : root.Load(file))
    throw std::runtime_error(error.Message());
  const auto *world = root.WorldByIndex(0);
  if (!world)
    throw std::runtime_error("no world in " + file);

  const auto simulated = Engine()->ConstructWorld(*world);
  for (std::uint64_t i = 0; i < world->ModelCount(); ++i)
  {
    const auto &model = *world->ModelByIndex(i);
    for (std::uint64_t j = 0; j < model.LinkCount(); ++j)
      AttachMeshes(simulated, model, *model.LinkByIndex(j), std::filesystem::path(file).parent_path());
  }

  std::vector<std::pair<Joint, double>> turning;
  for (const auto &each : told)
    turning.push_back(Turning(simulated, each));
  for (std::string some; std::getline(steps, some, ',');)
  {
    Step(simulated, turning, world->PhysicsByIndex(0)->MaxStepSize(), std::stoi(some));
    Print(simulated, *world);
  }
}

int main(int argc, char **argv)
try
{
  if (argc < 3)
    throw std::runtime_error("gazebo-engine WORLD STEPS[,STEPS...] [MODEL::JOINT=SPEED ...]");
  Run(argv[1], std::istringstream(argv[2]), {argv + 3, argv + argc});
}
catch (const std::exception &error)
{
  std::cerr << "gazebo-engine: " << error.what() << std::endl;
  return 1;
}
