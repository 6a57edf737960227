#include "engines/ode_rk4/runge_kutta.hpp"

#include <array>

namespace odeval::engine_rk4 {
namespace {

using Part = RungeKutta::Part;
using Stage = RungeKutta::Stage;

namespace classical {
constexpr std::array second{Part{0, 0.5}};
constexpr std::array third{Part{1, 0.5}};
constexpr std::array fourth{Part{2, 1}};
constexpr std::array<Stage, 4> stages{{{0, {}}, {0.5, second}, {0.5, third}, {1, fourth}}};
constexpr std::array weights{Part{0, 1.0 / 6}, Part{1, 1.0 / 3}, Part{2, 1.0 / 3}, Part{3, 1.0 / 6}};
}  // namespace classical

// E. Hairer, S.P. Norsett, G. Wanner: Solving Ordinary Differential Equations I, 2nd edition, section II.5: DOP853
// without the formulas of its error estimate.
namespace dormand_prince {
constexpr std::array s2{Part{0, 5.26001519587677318785587544488e-2}};
constexpr std::array s3{Part{0, 1.97250569845378994544595329183e-2}, Part{1, 5.91751709536136983633785987549e-2}};
constexpr std::array s4{Part{0, 2.95875854768068491816892993775e-2}, Part{2, 8.87627564304205475450678981324e-2}};
constexpr std::array s5{Part{0, 2.41365134159266685502369798665e-1}, Part{2, -8.84549479328286085344864962717e-1},
                        Part{3, 9.24834003261792003115737966543e-1}};
constexpr std::array s6{Part{0, 1.0 / 27}, Part{3, 1.70828608729473871279604482173e-1},
                        Part{4, 1.25467687566822425016691814123e-1}};
constexpr std::array s7{Part{0, 3.7109375e-2}, Part{3, 1.70252211019544039314978060272e-1},
                        Part{4, 6.02165389804559606850219397283e-2}, Part{5, -1.7578125e-2}};
constexpr std::array s8{Part{0, 3.70920001185047927108779319836e-2}, Part{3, 1.70383925712239993810214054705e-1},
                        Part{4, 1.07262030446373284651809199168e-1}, Part{5, -1.53194377486244017527936158236e-2},
                        Part{6, 8.27378916381402288758473766002e-3}};
constexpr std::array s9{Part{0, 6.24110958716075717114429577812e-1},  Part{3, -3.36089262944694129406857109825e0},
                        Part{4, -8.68219346841726006818189891453e-1}, Part{5, 2.75920996994467083049415600797e1},
                        Part{6, 2.01540675504778934086186788979e1},   Part{7, -4.34898841810699588477366255144e1}};
constexpr std::array s10{Part{0, 4.77662536438264365890433908527e-1},  Part{3, -2.48811461997166764192642586468e0},
                         Part{4, -5.90290826836842996371446475743e-1}, Part{5, 2.12300514481811942347288949897e1},
                         Part{6, 1.52792336328824235832596922938e1},   Part{7, -3.32882109689848629194453265587e1},
                         Part{8, -2.03312017085086261358222928593e-2}};
constexpr std::array s11{Part{0, -9.3714243008598732571704021658e-1}, Part{3, 5.18637242884406370830023853209e0},
                         Part{4, 1.09143734899672957818500254654e0},  Part{5, -8.14978701074692612513997267357e0},
                         Part{6, -1.85200656599969598641566180701e1}, Part{7, 2.27394870993505042818970056734e1},
                         Part{8, 2.49360555267965238987089396762e0},  Part{9, -3.0467644718982195003823669022e0}};
constexpr std::array s12{Part{0, 2.27331014751653820792359768449e0},  Part{3, -1.05344954667372501984066689879e1},
                         Part{4, -2.00087205822486249909675718444e0}, Part{5, -1.79589318631187989172765950534e1},
                         Part{6, 2.79488845294199600508499808837e1},  Part{7, -2.85899827713502369474065508674e0},
                         Part{8, -8.87285693353062954433549289258e0}, Part{9, 1.23605671757943030647266201528e1},
                         Part{10, 6.43392746015763530355970484046e-1}};
constexpr std::array<Stage, 12> stages{{{0, {}},
                                        {5.26001519587677318785587544488e-2, s2},
                                        {7.89002279381515978178381316732e-2, s3},
                                        {1.18350341907227396726757197510e-1, s4},
                                        {2.81649658092772603273242802490e-1, s5},
                                        {1.0 / 3, s6},
                                        {0.25, s7},
                                        {4.0 / 13, s8},
                                        {6.51282051282051282051282051282e-1, s9},
                                        {0.6, s10},
                                        {6.0 / 7, s11},
                                        {1, s12}}};
constexpr std::array weights{
    Part{0, 5.42937341165687622380535766363e-2},  Part{5, 4.45031289275240888144113950566e0},
    Part{6, 1.89151789931450038304281599044e0},   Part{7, -5.8012039600105847814672114227e0},
    Part{8, 3.1116436695781989440891606237e-1},   Part{9, -1.52160949662516078556178806805e-1},
    Part{10, 2.01365400804030348374776537501e-1}, Part{11, 4.47106157277725905176885569043e-2}};
}  // namespace dormand_prince

}  // namespace

const RungeKutta& runge_kutta(int order) {
  static const RungeKutta four{classical::stages, classical::weights};
  static const RungeKutta eight{dormand_prince::stages, dormand_prince::weights};
  return order == 8 ? eight : four;
}

}  // namespace odeval::engine_rk4
