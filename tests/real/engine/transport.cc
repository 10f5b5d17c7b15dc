// A world of Gazebo Sim's transport with no simulation behind it, over the library that the server uses:
//
//   gazebo-transport WORLD
//
// It offers the services of a server's world (control, create, remove, set_pose, scene/info) and publishes its topics
// (stats, pose/info, dynamic_pose/info) as often as a server does, and a robot's pose twenty times a simulated second.
// Models stay where they are put; a command to a robot sets its pose's x to the speed, so that it can be seen to be heard.
// It ends when its standard input does.

#include <atomic>
#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <ignition/msgs.hh>
#include <ignition/transport/Node.hh>
#include <sdf/sdf.hh>

namespace msgs = ignition::msgs;
namespace transport = ignition::transport;

struct Model
{
  unsigned id;
  bool isStatic;
  msgs::Pose pose;
  transport::Node::Publisher publisher;
};

class World
{
public:
  explicit World(const std::string &name) : prefix("/world/" + name + "/"), name(name)
  {
    add("ground_plane", true, msgs::Pose());
    node.Advertise("/gazebo/worlds", &World::worlds, this);
    node.Advertise(prefix + "control", &World::control, this);
    node.Advertise(prefix + "create", &World::create, this);
    node.Advertise(prefix + "remove", &World::remove, this);
    node.Advertise(prefix + "set_pose", &World::setPose, this);
    node.Advertise(prefix + "scene/info", &World::scene, this);
    transport::AdvertiseMessageOptions tenth, sixtieth;
    tenth.SetMsgsPerSec(10);
    sixtieth.SetMsgsPerSec(60);
    statistics = node.Advertise<msgs::WorldStatistics>(prefix + "stats", tenth);
    poses = node.Advertise<msgs::Pose_V>(prefix + "pose/info", sixtieth);
    moving = node.Advertise<msgs::Pose_V>(prefix + "dynamic_pose/info", sixtieth);
  }

  void update()
  {
    std::lock_guard<std::mutex> lock(mutex);
    const bool runs = !paused || toDo > 0;
    if (runs) ++steps;
    if (toDo > 0) --toDo;
    msgs::WorldStatistics now;
    setTime(*now.mutable_sim_time());
    now.mutable_real_time()->CopyFrom(now.sim_time());
    now.set_iterations(steps);
    now.set_paused(!runs);
    statistics.Publish(now);
    msgs::Pose_V all, some;
    setTime(*all.mutable_header()->mutable_stamp());
    some.mutable_header()->CopyFrom(all.header());
    for (auto &[model_name, model] : models)
    {
      model.pose.set_name(model_name);
      model.pose.set_id(model.id);
      all.add_pose()->CopyFrom(model.pose);
      if (!model.isStatic) some.add_pose()->CopyFrom(model.pose);
      if (!model.isStatic && runs && steps % 50 == 0)
      {
        msgs::Pose pose(model.pose);
        pose.mutable_header()->mutable_stamp()->CopyFrom(all.header().stamp());
        model.publisher.Publish(pose);
      }
      auto link = all.add_pose();  // a server's topic has links, by names that models may have too
      link->set_name("link");
      link->set_id(model.id + 1000);
    }
    poses.Publish(all);
    moving.Publish(some);
  }

private:
  void add(const std::string &model_name, bool isStatic, const msgs::Pose &pose)
  {
    auto publisher = node.Advertise<msgs::Pose>("/model/" + model_name + "/pose");
    models[model_name] = {++last, isStatic, pose, publisher};
    std::function<void(const msgs::Twist &)> heard = [this, model_name](const msgs::Twist &command)
    {
      std::lock_guard<std::mutex> lock(mutex);
      if (models.count(model_name)) models[model_name].pose.mutable_position()->set_x(command.linear().x());
    };
    node.Subscribe("/model/" + model_name + "/cmd_vel", heard);
  }

  void setTime(msgs::Time &time) const
  {
    time.set_sec(steps / 1000);
    time.set_nsec(steps % 1000 * 1000000);
  }

  bool worlds(msgs::StringMsg_V &answer)
  {
    answer.add_data(name);
    return true;
  }

  bool control(const msgs::WorldControl &order, msgs::Boolean &answer)
  {
    std::lock_guard<std::mutex> lock(mutex);
    paused = order.pause();
    toDo += order.multi_step();
    answer.set_data(true);
    return true;
  }

  bool create(const msgs::EntityFactory &order, msgs::Boolean &answer)
  {
    sdf::Root root;
    if (!root.LoadSdfString(order.sdf()).empty() || !root.Model()) return false;
    std::lock_guard<std::mutex> lock(mutex);
    answer.set_data(!models.count(root.Model()->Name()));
    if (answer.data()) add(root.Model()->Name(), root.Model()->Static(), order.pose());
    return true;
  }

  bool remove(const msgs::Entity &order, msgs::Boolean &answer)
  {
    std::lock_guard<std::mutex> lock(mutex);
    answer.set_data(order.type() == msgs::Entity::MODEL && models.erase(order.name()) == 1);
    return true;
  }

  bool setPose(const msgs::Pose &order, msgs::Boolean &answer)
  {
    std::lock_guard<std::mutex> lock(mutex);
    answer.set_data(models.count(order.name()) == 1);
    if (answer.data()) models[order.name()].pose = order;
    return true;
  }

  bool scene(msgs::Scene &answer)
  {
    std::lock_guard<std::mutex> lock(mutex);
    for (const auto &[model_name, model] : models)
    {
      auto told = answer.add_model();
      told->set_name(model_name);
      told->set_id(model.id);
    }
    return true;
  }

  std::mutex mutex;
  transport::Node node;
  std::string prefix, name;
  transport::Node::Publisher statistics, poses, moving;
  std::map<std::string, Model> models;
  unsigned last = 7;
  std::uint64_t steps = 0, toDo = 0;
  bool paused = true;
};

int main(int, char **arguments)
{
  World world(arguments[1]);
  std::atomic<bool> ends{false};
  std::thread waiting([&ends] { std::cin.get(); ends = true; });
  while (!ends)
  {
    world.update();
    std::this_thread::sleep_for(std::chrono::microseconds(300));
  }
  waiting.join();
}
