// SPDX-License-Identifier: MIT
// Which card, which of its connectors and which mode are meant by the options.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "platform/base/error.h"
#include "platform/kms/card/kms_card.h"
#include "platform/kms/kms_log.h"
#include "platform/kms/kms_options.h"
#include "platform/seat/seat.h"

namespace karst {

class KmsChoice {
 public:
  // All must outlive this.
  KmsChoice(const KmsOptions& options, Seat& seat, KmsLog& log) : options_(options), seat_(seat), log_(log) {}

  // Opens the card with the wanted monitor, or with another where the options allow that. Where there is
  // none, the card stays closed; why is told once.
  void find(KmsCard& card, KmsConnector& connector);

  // Index of the connector to use, the one with this id before others; connectors.size() where none has the
  // wanted monitor.
  std::size_t pick(const std::vector<KmsConnector>& connectors, std::uint32_t id) const;

  // Whether a card other than this one has the wanted monitor.
  bool is_on_another_card(const KmsCard& card);

  // Index of the connector's mode to use. The error names the option, and what there is.
  Error choose(const KmsConnector& connector, std::size_t& mode);

 private:
  bool usable(const KmsConnector& connector) const;

  const KmsOptions& options_;
  Seat& seat_;
  KmsLog& log_;
  std::vector<std::string> last_reasons_;  // why cards were of no use
};

}  // namespace karst
